#include <difusa/core/error.h>
#include <difusa/plugin/parameters.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <string>

namespace difusa::parameters_test {
namespace {

using difusa::nearest_name;
using difusa::Parameters;
using difusa::ParameterSpec;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<ParameterSpec> specs() {
    using Type = ParameterSpec::Type;
    return {{"width", Type::real, "0.5", "support in metres", 0.0, 4.0, {}},
            {"max-steps", Type::integer, "8", "steps", 1, 1e300, {}},
            {"profile", Type::word, "gaussian", "shape", 0, 0, {"gaussian", "cubic"}},
            {"eye", Type::vector, "", "position; empty: the middle", 0, 0, {}},
            {"shift", Type::real, "", "any; empty: none", -1e300, 1e300, {}}};
}

Parameters parse(std::string_view text) {
    return Parameters(text, specs(), "basis radial");
}

std::string usage_error(std::string_view text) {
    try {
        (void)parse(text);
    } catch (const difusa::UsageError& error) {
        return error.what();
    }
    return "";
}

TEST(ParametersTest, DefaultsWhereNothingIsGiven) {
    const Parameters parameters = parse("");
    EXPECT_EQ(parameters.real("width"), 0.5);
    EXPECT_EQ(parameters.integer("max-steps"), 8);
    EXPECT_EQ(parameters.word("profile"), "gaussian");
    EXPECT_THAT(parameters.vector("eye"), IsEmpty());
    EXPECT_FALSE(parameters.given("width"));
    EXPECT_EQ(parameters.text(), "width=0.5,max-steps=8,profile=gaussian");
}

TEST(ParametersTest, GivenValuesOfEachType) {
    const Parameters parameters = parse("eye=1/-2.5/3e-1, max_steps=20,profile=cubic ,width=+1.25,shift=-0.125");
    EXPECT_EQ(parameters.real("width"), 1.25);
    EXPECT_EQ(parameters.real("shift"), -0.125);
    EXPECT_EQ(parameters.integer("max_steps"), 20);
    EXPECT_EQ(parameters.word("profile"), "cubic");
    EXPECT_THAT(parameters.vector("eye"), ElementsAre(1.0, -2.5, 0.3));
    EXPECT_TRUE(parameters.given("max-steps"));
    EXPECT_TRUE(parameters.given("max_steps"));
    EXPECT_EQ(parameters.text(), "width=+1.25,max-steps=20,profile=cubic,eye=1/-2.5/3e-1,shift=-0.125");
}

TEST(ParametersTest, TextParsesToTheSameValues) {
    for (const char* given : {"", "width=0.1,eye=1/2/3", "shift=7,eye="}) {
        const std::string text = parse(given).text();
        EXPECT_EQ(parse(text).text(), text);
    }
}

TEST(ParametersTest, BoundsBelongToTheRange) {
    EXPECT_EQ(parse("width=0").real("width"), 0.0);
    EXPECT_EQ(parse("width=4").real("width"), 4.0);
    EXPECT_THAT(usage_error("width=4.0000000000000009"), AllOf(HasSubstr("'width'"), HasSubstr("from 0 to 4")));
    EXPECT_THAT(usage_error("width=-1e-300"), HasSubstr("from 0 to 4"));
    EXPECT_THAT(usage_error("max-steps=0"), HasSubstr("a whole number of at least 1"));
}

TEST(ParametersTest, RefusesWhatDoesNotParse) {
    for (const char* text : {"width=", "width=abc", "width=1.5x", "width=nan", "width=inf", "width=1e999", "width=0x10",
                             "width=+-1", "width=+", "max-steps=2.5", "max-steps=99999999999999999999", "profile=cub",
                             "profile=", "eye=1//3", "eye=1/2/", "eye=a", "shift="}) {
        EXPECT_THAT(usage_error(text), AllOf(HasSubstr("basis radial"), HasSubstr("must be"))) << text;
    }
    EXPECT_THAT(usage_error("profile=Cubic"), HasSubstr("one of gaussian, cubic"));
    for (const char* text : {"width", "=3", ",", "width=1,", "width=1,,profile=cubic"}) {
        EXPECT_THAT(usage_error(text), HasSubstr("name=value")) << text;
    }
}

TEST(ParametersTest, RefusesUnknownAndRepeatedNames) {
    EXPECT_THAT(usage_error("widht=1"), AllOf(HasSubstr("'widht'"), HasSubstr("mean 'width'?"),
                                              HasSubstr("It has: width, max-steps, profile, eye, shift")));
    EXPECT_THAT(usage_error("colour=red"), AllOf(Not(HasSubstr("mean")), HasSubstr("It has: width")));
    EXPECT_THAT(usage_error("max-steps=1,max_steps=1"), HasSubstr("given twice"));
    try {
        Parameters("k=1", {}, "basis flat");
        FAIL() << "nothing thrown";
    } catch (const difusa::UsageError& error) {
        EXPECT_THAT(error.what(), HasSubstr("it has none"));
    }
}

TEST(ParametersTest, MistakesOfThePluginAreInternalErrors) {
    const Parameters parameters = parse("");
    EXPECT_THROW((void)parameters.real("height"), difusa::InternalError);
    EXPECT_THROW((void)parameters.real("max-steps"), difusa::InternalError);
    EXPECT_THROW((void)parameters.word("eye"), difusa::InternalError);
    EXPECT_THROW((void)parameters.real("shift"), difusa::InternalError) << "empty and not given";
    EXPECT_THROW(Parameters("", {{"a", ParameterSpec::Type::word, "x", "", 0, 0, {"y"}}}, "basis"),
                 difusa::InternalError);
    EXPECT_THROW(Parameters("", {{"a", {}, "1", "", 0, 2, {}}, {"a", {}, "1", "", 0, 2, {}}}, "basis"),
                 difusa::InternalError);
}

TEST(ParametersTest, NumbersDoNotDependOnTheLocale) {
    const std::string before = std::setlocale(LC_NUMERIC, nullptr);
    std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
    EXPECT_EQ(parse("width=1.25").real("width"), 1.25);
    std::setlocale(LC_NUMERIC, before.c_str());
}

TEST(NearestNameTest, CountsEdits) {
    const std::vector<std::string> known = {"radial", "normalized-radial", "shepard"};
    EXPECT_EQ(nearest_name("radial", known), "radial");
    EXPECT_EQ(nearest_name("raidal", known), "radial") << "two neighbours exchanged";
    EXPECT_EQ(nearest_name("shephard", known), "shepard");
    EXPECT_EQ(nearest_name("normalised_radial", known), "normalized-radial");
    EXPECT_EQ(nearest_name("rdil", known), "") << "two edits in four letters";
    EXPECT_EQ(nearest_name("hemicube", known), "");
    EXPECT_EQ(nearest_name("", known), "");
    EXPECT_EQ(nearest_name("x", {}), "");
    EXPECT_EQ(nearest_name("x", {"y"}), "y") << "one edit is always near";
    EXPECT_EQ(nearest_name("ab", {"ac", "ad"}), "ac") << "the first of equals";
}

} // namespace
} // namespace difusa::parameters_test
