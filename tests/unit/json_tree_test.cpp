// JSON text as a tree.
#include <difusa/core/error.h>
#include <difusa/import/json_tree.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace difusa::json_tree_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(JsonTree, ValuesKnowTheirLines) {
    const JsonValue root =
        parse_json("{\n\"a\": 1,\n\"b\"\n:\n[true\n,2\n,-3.5e1\n, null], \"c\": {\"d\":\n\"x\\ny\"}\n}\n", "a.json");
    EXPECT_EQ(root.line, 1U);
    EXPECT_EQ(root.find("a")->line, 2U);
    const JsonValue& b = *root.find("b");
    EXPECT_EQ(b.line, 5U);
    ASSERT_EQ(b.items.size(), 4U);
    EXPECT_EQ(b.items[0].line, 5U);
    EXPECT_TRUE(b.items[0].truth);
    EXPECT_EQ(b.items[1].line, 6U);
    EXPECT_EQ(b.items[1].number, 2.0);
    EXPECT_EQ(b.items[2].line, 7U);
    EXPECT_EQ(b.items[2].number, -35.0);
    EXPECT_EQ(b.items[3].line, 8U);
    EXPECT_EQ(b.items[3].kind, JsonValue::Kind::null);
    EXPECT_EQ(root.find("c")->line, 8U);
    EXPECT_EQ(root.find("c")->find("d")->line, 9U);
    EXPECT_EQ(root.find("c")->find("d")->text, "x\ny");
    EXPECT_EQ(root.find("e"), nullptr);
}

TEST(JsonTree, RefusesWhatIsNoJson) {
    const auto refusal = [](const std::string& text) -> std::string {
        try {
            parse_json(text, "a.json");
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_THAT(refusal("{\n\"a\": 1,\n}"), AllOf(HasSubstr("a.json:3: "), HasSubstr("this is not JSON")));
    EXPECT_THAT(refusal(""), HasSubstr("a.json:1: "));
    EXPECT_THAT(refusal("{} {}"), HasSubstr("a.json:1: "));
    EXPECT_THAT(refusal("[1, nan]"), HasSubstr("not JSON"));
    EXPECT_THAT(refusal("[1,\n1e999,\n2]"), AllOf(HasSubstr("a.json:2: '1e999' is too large: "),
                                                  Not(HasSubstr("exception")), Not(HasSubstr("not JSON"))));
    EXPECT_THAT(refusal("-1e400"), HasSubstr("a.json:1: '-1e400' is too large: "));
    EXPECT_THAT(refusal("{\"a\": 1,\n\"b\": 2,\n\"a\": 3}"),
                AllOf(HasSubstr("a.json:3: 'a' occurs twice"), HasSubstr("line 1")));
    EXPECT_EQ(refusal(std::string(64, '[') + std::string(64, ']')), "");
    EXPECT_THAT(refusal(std::string(65, '[') + std::string(65, ']')), HasSubstr("nested"));
    EXPECT_THAT(refusal(std::string(1000000, '[')), HasSubstr("nested"));
}

} // namespace
} // namespace difusa::json_tree_test
