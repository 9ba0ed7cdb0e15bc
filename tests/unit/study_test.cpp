#include <difusa/study/study.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <limits>

namespace difusa::study_test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Made up: nothing is baked.
Measurement made_up(const std::string& basis, double spacing, double error) {
    Measurement m;
    m.case_name = "sphere";
    m.options.basis = basis;
    m.options.spacing = spacing;
    m.options.rays = 1024;
    m.sites = 100;
    m.seconds = 1.5;
    m.seconds_output = 0.5;
    m.total.area = 2.0;
    m.total.l2 = {error, 4.0};
    m.total.linf = {2.0 * error, 4.0};
    m.bound = 3.0 * error;
    return m;
}

std::vector<Measurement> three() {
    std::vector<Measurement> all{made_up("shepard", 0.5, 0.4), made_up("shepard", 0.25, 0.2),
                                 made_up("radial", 0.5, 0.0)};
    all[2].failed = true;
    all[2].failure = "it said \"no\", twice";
    return all;
}

TEST(Study, CsvHasALineForEachMeasurement) {
    const std::string csv = csv_of(three());
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
    const std::string header = csv.substr(0, csv.find('\n'));
    for (const char* const name : {"case,basis,projection,transport", "relative_l2", "bound_over_error", "failure"}) {
        EXPECT_THAT(header, HasSubstr(name));
    }
    EXPECT_THAT(csv, HasSubstr("\"it said \"\"no\"\", twice\""));
}

TEST(Study, JsonHasTheSameNumbersAndNullForWhatIsNotKnown) {
    std::vector<Measurement> all = three();
    all[1].bound = std::numeric_limits<double>::infinity();
    const auto study = nlohmann::json::parse(json_of(all));
    EXPECT_EQ(study["schema"], "difusa-accuracy-study");
    const auto& m = study["measurements"];
    ASSERT_EQ(m.size(), 3U);
    EXPECT_EQ(m[0]["relative_l2"], 0.1);
    EXPECT_DOUBLE_EQ(m[0]["bound_over_error"].get<double>(), 3.0);
    EXPECT_TRUE(m[0]["indirect_relative_l2"].is_null());
    EXPECT_TRUE(m[1]["bound_over_error"].is_null());
    EXPECT_TRUE(m[2]["seconds"].is_null());
    EXPECT_EQ(m[2]["failure"], "it said \"no\", twice");
}

TEST(Study, TablesAndChartsShowTheirCaseOnly) {
    std::vector<Measurement> all = three();
    all.push_back(made_up("moving-least-squares", 0.5, 0.1));
    all.back().case_name = "bowl";
    const std::string table = markdown_of(all, "sphere");
    EXPECT_THAT(table, HasSubstr("| shepard | 0.5 | 1024 | 100 | 2.00 | 1.0e-01 | – | 2.0e-01 | 3.0 |"));
    EXPECT_THAT(table, HasSubstr("| radial | 0.5 | 1024 | – | – | it said \"no\", twice |"));
    EXPECT_THAT(table, Not(HasSubstr("moving")));
    for (const std::string& chart : {error_against_time(all, "sphere"), error_against_sites(all, "sphere")}) {
        EXPECT_THAT(chart, HasSubstr(">shepard<"));
        EXPECT_THAT(chart, Not(HasSubstr(">radial<"))); // it has no values
        EXPECT_THAT(chart, Not(HasSubstr("moving")));
    }
}

TEST(Study, MethodsAreTold) {
    Measurement m = made_up("shepard", 1, 1);
    EXPECT_EQ(method_of(m), "shepard");
    m.options.projection = "galerkin";
    m.options.transport = "pairwise";
    m.options.final_gather = 64;
    EXPECT_EQ(method_of(m), "shepard, galerkin, pairwise, final gather 64");
}

} // namespace
} // namespace difusa::study_test
