// data/schemas/report.schema.json says what is in a report: nothing else is, and nothing it names is never there.
#include "support/json_schema.h"
#include "support/plugins.h"
#include "support/saved_bakes.h"

#include <difusa/bake.h>
#include <difusa/output/bake_files.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <string>

namespace difusa::report_schema_test {

using nlohmann::json;

const std::string data = DIFUSA_TEST_DATA "/";

json schema() {
    return json::parse(std::ifstream(data + "schemas/report.schema.json"));
}

BakeOptions few_sites() {
    BakeOptions options;
    options.sites = 60;
    options.rays = 32;
    options.error_points = 32;
    return options;
}

json report(const std::string& scene, const BakeOptions& options) {
    return json::parse(report_of(bake(test::registry(), data + scene, options, Execution{})));
}

json dry_report(const std::string& scene) {
    return json::parse(report_of(dry_run(test::registry(), data + scene, few_sites(), Execution{})));
}

/// Of a saved transport in which a block is moved, and a lamp is brighter.
json report_of_moved(const std::string& scene) {
    const SavedTransport saved = test::through_file(bake(test::registry(), data + scene, few_sites(), Execution{}));
    RelightOptions how;
    how.bake = relight_defaults(saved);
    how.bake.error_points = 32;
    how.factors = {{"lamp", 1.5}};
    how.moves.push_back({"10-14", 0.0, {}});
    how.moves.front().motion.offset = Vec3(0.05, 0.0, -0.02);
    return json::parse(report_of(relight(test::registry(), saved, how, Execution{})));
}

/// Groups, goals, grids and an accuracy that is not reached.
BakeOptions much() {
    BakeOptions options;
    options.light_groups = true;
    options.goals = {{"red wall", {"red"}, {}, {}}, {"desk", {}, {}, {{Vec3(0.3, 0.0, 0.3), Vec3::UnitY()}}}};
    options.target = ErrorTarget{2e-2, 120, 1e9, true};
    options.suns = {{Vec3(0.0, 0.3, -1.0).normalized(), Rgb::Constant(3.0)}};
    return options;
}

BakeOptions with_grid() {
    BakeOptions options = few_sites();
    options.grids = {{"0", 0.75, 0.5, 0.1}};
    return options;
}

BakeOptions subdivided() {
    BakeOptions options = few_sites();
    options.basis = "patch-constant";
    options.adaptive = true;
    return options;
}

BakeOptions pairwise() {
    BakeOptions options = few_sites();
    options.transport = "pairwise";
    options.stop = "change";
    options.solver = "gauss-seidel";
    return options;
}

TEST(ReportSchema, SaysWhatIsInAReport) {
    test::JsonSchema all(schema());
    const std::pair<std::string, BakeOptions> bakes[] = {
        {"cornell_box.json", much()},      {"office.json", with_grid()},       {"oven.json", few_sites()},
        {"mirror_room.json", few_sites()}, {"glossy_floor.json", few_sites()}, {"furnace_box.obj", subdivided()},
        {"ugly.off", pairwise()}};
    for (const auto& [scene, options] : bakes) {
        EXPECT_THAT(all.faults(report(scene, options)), testing::IsEmpty()) << scene;
    }
    for (const char* scene : {"cornell_box.obj", "room_a.json"}) {
        EXPECT_THAT(all.faults(dry_report(scene)), testing::IsEmpty()) << scene;
    }
    EXPECT_THAT(all.faults(report_of_moved("cornell_box.obj")), testing::IsEmpty());
    EXPECT_THAT(all.never_met(), testing::IsEmpty());
}

TEST(ReportSchema, TellsWhatIsWrong) {
    const json sound = report("cornell_box.obj", few_sites());
    const auto faults_of = [](const json& changed) { return test::JsonSchema(schema()).faults(changed); };
    ASSERT_THAT(faults_of(sound), testing::IsEmpty());
    json changed = sound;
    changed["sites"]["number"] = 3;
    EXPECT_THAT(faults_of(changed), testing::ElementsAre("/sites/number: unknown"));
    changed = sound;
    changed["sites"].erase("count");
    EXPECT_THAT(faults_of(changed), testing::ElementsAre("/sites/count: missing"));
    changed = sound;
    changed["options"]["units"] = "feet";
    EXPECT_THAT(faults_of(changed), testing::ElementsAre("/options/units: \"feet\" is no value of it"));
    changed = sound;
    changed["error"]["points"] = "many";
    EXPECT_THAT(faults_of(changed), testing::Contains("/error/points: is string, not \"integer\""));
    changed = sound;
    changed.erase("energy");
    EXPECT_THAT(faults_of(changed), testing::ElementsAre("/energy: missing"));
    changed = sound;
    changed["transport"].erase("surfels");
    EXPECT_THAT(faults_of(changed), testing::ElementsAre("/transport/surfels: missing"));
}

} // namespace difusa::report_schema_test
