#include "support/plugins.h"
#include <difusa/core/error.h>
#include <difusa/plugin/module_file.h>
#include <difusa/plugin/registry.h>
#include <difusa/transport/kernel.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

namespace difusa::registry_test {
namespace {

using difusa::Kernel;
using difusa::Registry;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
namespace fs = std::filesystem;

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// A fresh directory that is removed at the end.
class Directory {
  public:
    Directory() : path_(fs::temp_directory_path() / ("difusa_registry_" + std::to_string(std::random_device{}()))) {
        fs::create_directories(path_);
    }
    ~Directory() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    Directory(const Directory&) = delete;
    Directory& operator=(const Directory&) = delete;

    fs::path write(const std::string& name, const std::string& text) const {
        std::ofstream(path_ / name, std::ios::binary) << text;
        return path_ / name;
    }
    fs::path copy(const std::string& name) const {
        fs::copy_file(test::test_module(name), path_ / (name + ".so"));
        return path_ / (name + ".so");
    }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

class EnvironmentVariable {
  public:
    EnvironmentVariable(const char* name, const std::string& value) : name_(name) { setenv(name, value.c_str(), 1); }
    ~EnvironmentVariable() { unsetenv(name_); }
    EnvironmentVariable(const EnvironmentVariable&) = delete;
    EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

  private:
    const char* name_;
};

/// The reason for which a registry refuses a module, or "" if it does not.
std::string refusal(const fs::path& file) {
    Registry registry;
    return registry.add(file) ? "" : registry.refused().at(0).reason;
}

std::string usage_error(const Registry& registry, std::string_view choice) {
    try {
        (void)registry.create<Kernel>(choice);
    } catch (const difusa::UsageError& error) {
        return error.what();
    }
    return "";
}

double form_factor(const Kernel& kernel, double area) {
    using difusa::Vec3;
    return kernel.form_factor(Vec3::Zero(), Vec3::UnitZ(), Vec3::UnitZ(), -Vec3::UnitZ(), area);
}

TEST(RegistryTest, MakesAPluginWithItsParameters) {
    Registry registry;
    ASSERT_TRUE(registry.add(test::test_module("well_made")));
    EXPECT_EQ(form_factor(*registry.create<Kernel>("well-made"), 4.0), 2.0);
    EXPECT_EQ(form_factor(*registry.create<Kernel>("well_made:factor=0.25,times=3"), 4.0), 3.0);
    EXPECT_EQ(registry.describe("kernel", "well_made:times=2"), "well-made:factor=0.5,times=2");
    EXPECT_THAT(registry.names("kernel"), ElementsAre("well-made"));
    EXPECT_THAT(registry.names("basis"), IsEmpty());
    EXPECT_EQ(registry.find("basis", "well-made"), nullptr);
}

TEST(RegistryTest, NamesThePluginThatCannotBeMade) {
    Registry registry;
    ASSERT_TRUE(registry.add(test::test_module("well_made")));
    try {
        (void)registry.create<Kernel>("well-made:times=9");
        ADD_FAILURE() << "it was made";
    } catch (const difusa::InternalError& error) {
        EXPECT_THAT(error.what(), AllOf(HasSubstr("kernel well-made ("), HasSubstr("well_made.so"),
                                        HasSubstr("cannot be made: no licence")));
    }
}

TEST(RegistryTest, RefusesProgramsOfAnotherBuild) {
    EXPECT_GT(Registry::load().plugins().size(), 10U);
    EXPECT_THROW(Registry::load({}, "interface=8;library=libstdc++1;eigen=3.4.0/32/32/0"), difusa::UsageError);
}

TEST(RegistryTest, ObjectsOutliveTheRegistry) {
    std::shared_ptr<Kernel> kernel;
    {
        Registry registry;
        ASSERT_TRUE(registry.add(test::test_module("well_made")));
        kernel = registry.create<Kernel>("well-made");
    }
    EXPECT_EQ(form_factor(*kernel, 2.0), 1.0);
}

TEST(RegistryTest, UnknownNameIsRefusedWithTheNearest) {
    Registry registry;
    ASSERT_TRUE(registry.add(test::test_module("well_made")));
    EXPECT_THAT(usage_error(registry, "wel-made"), AllOf(HasSubstr("'wel-made'"), HasSubstr("mean 'well-made'?")));
    EXPECT_THAT(usage_error(registry, "hemisphere"), AllOf(Not(HasSubstr("mean")), HasSubstr("Known: well-made")));
    EXPECT_THAT(usage_error(registry, ""), HasSubstr("Known: well-made"));
    EXPECT_THAT(usage_error(registry, "well-made:factr=1"),
                AllOf(HasSubstr("kernel well-made"), HasSubstr("mean 'factor'?")));
    EXPECT_THAT(usage_error(Registry(), "point"), HasSubstr("None was found"));
}

TEST(RegistryTest, UnknownNameOfARefusedModuleIsExplained) {
    Registry registry;
    ASSERT_FALSE(registry.add(test::test_module("wrong_version")));
    EXPECT_THAT(usage_error(registry, "wrong-version"), AllOf(HasSubstr("refused"), HasSubstr("999999")));

    const Directory directory;
    ASSERT_FALSE(registry.add(directory.write("kernels_my_disc.so", "no longer a plugin")));
    EXPECT_THAT(usage_error(registry, "my-disc"), HasSubstr("kernels_my_disc.so was refused: not a shared object"));
    EXPECT_THAT(usage_error(registry, "disc2"), Not(HasSubstr("refused")));
}

TEST(RegistryTest, CodeOfARefusedModuleDoesNotRun) {
    const Directory directory;
    const fs::path marker = directory.path() / "marker";
    const EnvironmentVariable variable("DIFUSA_TEST_MARKER", marker.string());
    EXPECT_THAT(refusal(test::test_module("wrong_version")),
                AllOf(HasSubstr("interface tag is 999999"),
                      HasSubstr("expected " + std::to_string(DIFUSA_INTERFACE_VERSION)), HasSubstr("rebuild it")));
    EXPECT_FALSE(fs::exists(marker));
}

TEST(RegistryTest, RefusesModulesThatDoNotKeepTheContract) {
    EXPECT_THAT(refusal(test::test_module("no_entry")), HasSubstr("no entry difusa_plugin_entry"));
    EXPECT_THAT(refusal(test::test_module("throwing_entry")), HasSubstr("licence of this plugin has expired"));
    EXPECT_THAT(refusal(test::test_module("other_name")), AllOf(HasSubstr("'delivered'"), HasSubstr("'promised'")));
    EXPECT_THAT(refusal(test::test_module("unknown_kind")),
                AllOf(HasSubstr("'teapot'"), HasSubstr("basis, directions")));
    EXPECT_THAT(refusal(test::test_module("bad_default")), AllOf(HasSubstr("'width'"), HasSubstr("from 0 to 1")));
    EXPECT_THAT(refusal(test::test_module("not_a_plugin")), HasSubstr("not a difusa plugin"));
}

TEST(RegistryTest, RefusesWhatIsNoModule) {
    const Directory directory;
    EXPECT_THAT(refusal(directory.write("empty.so", "")), HasSubstr("too short"));
    EXPECT_THAT(refusal(directory.write("text.so", "INPUT(libm.so.6) but no plugin")), HasSubstr("ELF magic number"));
    EXPECT_THAT(refusal(directory.path() / "missing.so"), HasSubstr("not a regular file"));
    EXPECT_THAT(refusal(directory.path()), HasSubstr("not a regular file"));

    const std::string good = content(test::test_module("well_made"));
    std::string foreign = good;
    foreign[18] = static_cast<char>(foreign[18] ^ 0x7f); // e_machine
    EXPECT_THAT(refusal(directory.write("foreign.so", foreign)), HasSubstr("another processor"));
    std::string narrow = good;
    narrow[4] = narrow[4] == 1 ? 2 : 1; // e_ident[EI_CLASS]
    EXPECT_THAT(refusal(directory.write("narrow.so", narrow)), HasSubstr("word size"));
    std::string object_file = good;
    object_file[16] = 1; // e_type = ET_REL
    EXPECT_THAT(refusal(directory.write("object.so", object_file)), HasSubstr("another kind of ELF file"));
}

TEST(RegistryTest, RefusesEveryTruncation) {
    const Directory directory;
    const std::string good = content(test::test_module("well_made"));
    const std::size_t step = std::max<std::size_t>(1, good.size() / 97);
    for (std::size_t length = 0; length < good.size(); length += step) {
        EXPECT_NE(refusal(directory.write("short.so", good.substr(0, length))), "") << length << " bytes";
    }
    EXPECT_NE(refusal(directory.write("short.so", good.substr(0, good.size() - 1))), "");
}

TEST(RegistryTest, DamagedHeadersNeverCrashTheTagReader) {
    const Directory directory;
    const std::string good = content(test::test_module("well_made"));
    // Each byte of the ELF header, set to each of a few values: refused with a reason, or harmless.
    for (std::size_t byte = 0; byte < 64; ++byte) {
        for (const char value : {'\0', '\x01', '\x7f', '\xff'}) {
            std::string damaged = good;
            damaged[byte] = value;
            try {
                (void)difusa::read_module_tag(directory.write("damaged.so", damaged));
            } catch (const difusa::ModuleRefused& refused) {
                EXPECT_STRNE(refused.what(), "") << "byte " << byte;
            }
        }
    }
}

TEST(RegistryTest, TagMustBeWhole) {
    EXPECT_THROW(difusa::parse_module_tag(""), difusa::ModuleRefused);
    EXPECT_THROW(difusa::parse_module_tag("difusa-plugin"), difusa::ModuleRefused);
    EXPECT_THROW(difusa::parse_module_tag("other-plugin;kind=a;name=b"), difusa::ModuleRefused);
    EXPECT_THROW(difusa::parse_module_tag("difusa-plugin;kind;name=b"), difusa::ModuleRefused);
    EXPECT_THROW(difusa::parse_module_tag("difusa-plugin;name=b;kind=a"), difusa::ModuleRefused);
    EXPECT_THROW(difusa::parse_module_tag("difusa-plugin;kind=a;name=../b"), difusa::ModuleRefused);
    EXPECT_THROW(difusa::parse_module_tag("difusa-plugin;kind=a;name="), difusa::ModuleRefused);
    const difusa::ModuleTag tag = difusa::parse_module_tag("difusa-plugin;kind=a;name=b-2;interface=7");
    EXPECT_EQ(tag.kind, "a");
    EXPECT_EQ(tag.name, "b-2");
    EXPECT_THAT(tag.build, ElementsAre(std::pair<std::string, std::string>("interface", "7")));
}

TEST(RegistryTest, FirstOfTwoWithOneNameWins) {
    Registry registry;
    ASSERT_TRUE(registry.add(test::test_module("well_made")));
    ASSERT_FALSE(registry.add(test::test_module("same_name")));
    EXPECT_THAT(registry.refused().at(0).reason, AllOf(HasSubstr("already found"), HasSubstr("well_made.so")));
    EXPECT_EQ(form_factor(*registry.create<Kernel>("well_made"), 2.0), 1.0);
}

TEST(RegistryTest, LoadsTheRestBesideBadModules) {
    const Directory directory;
    const EnvironmentVariable variable("DIFUSA_TEST_MARKER", (directory.path() / "marker").string());
    for (const char* name : {"no_entry", "throwing_entry", "wrong_version", "well_made"}) {
        directory.copy(name);
    }
    directory.write("aaa_text.so", "not a module");
    directory.write("well_made.txt", "not looked at");
    const Registry registry = Registry::load({directory.path()});
    const difusa::LoadedPlugin* plugin = registry.find("kernel", "well-made");
    ASSERT_NE(plugin, nullptr);
    EXPECT_EQ(plugin->file, directory.path() / "well_made.so");
    std::vector<std::string> refused;
    for (const difusa::RefusedPlugin& one : registry.refused()) {
        refused.push_back(one.file.filename().string());
    }
    EXPECT_THAT(refused, ElementsAre("aaa_text.so", "no_entry.so", "throwing_entry.so", "wrong_version.so"));
    EXPECT_FALSE(fs::exists(directory.path() / "marker"));
}

TEST(RegistryTest, SearchesExtraThenEnvironmentThenItsOwnDirectory) {
    const Directory first, second;
    const EnvironmentVariable variable("DIFUSA_PLUGIN_PATH", second.path().string() + "::/nowhere/plugins");
    const std::vector<fs::path> path = Registry::search_path({first.path()});
    ASSERT_EQ(path.size(), 4U);
    EXPECT_EQ(path[0], first.path());
    EXPECT_EQ(path[1], second.path());
    EXPECT_EQ(path[2], "/nowhere/plugins");
    EXPECT_EQ(path[3], difusa::library_directory() / "difusa" / "plugins");

    first.copy("well_made");
    fs::copy_file(test::test_module("same_name"), second.path() / "same_name.so");
    const Registry registry = Registry::load({first.path(), first.path()});
    EXPECT_EQ(registry.find("kernel", "well-made")->file, first.path() / "well_made.so");
    ASSERT_EQ(registry.refused().size(), 2U) << "a directory named twice is listed once";
    EXPECT_EQ(registry.refused()[0].file, second.path() / "same_name.so");
    EXPECT_THAT(registry.refused()[1].reason, HasSubstr("DIFUSA_PLUGIN_PATH"));
}

TEST(RegistryTest, MissingExtraDirectoryIsTheUsersMistake) {
    try {
        (void)Registry::load({"/nowhere/plugins"});
        FAIL() << "nothing thrown";
    } catch (const difusa::UsageError& error) {
        EXPECT_THAT(error.what(), AllOf(HasSubstr("'/nowhere/plugins'"), HasSubstr("name a directory")));
    }
}

TEST(RegistryTest, AllPluginsOfTheProjectAreFoundWithoutRefusals) {
    const Registry registry = Registry::load();
    for (const difusa::RefusedPlugin& refused : registry.refused()) {
        ADD_FAILURE() << refused.file << ": " << refused.reason;
    }
    for (const char* kind : {"basis", "directions", "kernel", "reader", "sampler", "solver", "visibility"}) {
        EXPECT_THAT(registry.names(kind), Not(IsEmpty())) << kind;
    }
}

} // namespace
} // namespace difusa::registry_test
