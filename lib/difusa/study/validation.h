// Published validation cases of lighting programs: their scenes, what is measured in them, and by what it is judged.
#pragma once

#include <difusa/bake.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

/// A figure that the report asks for: at one point of the surface, or a weighted sum over several.
struct ValidationReading {
    std::string name;                ///< the report's letter of the point
    std::vector<ListedPoint> places; ///< points of the surface with their normals
    std::vector<double> weight;      ///< of each place: 1 for a single one
    double exact = 0.0;              ///< by closed form or quadrature of the geometry as read here
    std::optional<double> published; ///< as the report has it
    bool doubtful = false;           ///< the published figure is known to be wrong, or contradicts others
};

/// A scene with its readings; all figures in the case's unit.
struct ValidationCase {
    std::string name; ///< "5.9 roof 1x1, sky 12": the report's number first
    std::string unit;
    double unit_of_watts = 1.0; ///< what an irradiance of 1 W/m² is in that unit
    bool indirect = false;      ///< readings are of the light after one reflection or more
    Scene scene;
    std::vector<ValidationReading> readings;
    std::function<double(const Vec3& x, const Vec3& n)> exact; ///< at any place inside; null: of the readings alone
};

/// Those of CIE 171:2006, "Test Cases to Assess the Accuracy of Lighting Computer Programs", chapter 5, as far as all
/// surfaces are diffuse and there is no glass. With lamps: 5.2 to 5.8. Under CIE general skies of types 1, 5 and 12
/// with the sun 60° high in the south, without its direct light: 5.9, 5.11, 5.13 and 5.14, in % of the irradiance of
/// the unobstructed ground. data/VALIDATION.md says how the geometry is read and where the figures come from.
std::vector<ValidationCase> cie_171_lamps();
std::vector<ValidationCase> cie_171_daylight();

/// Both, or those whose names begin with one of `starts`. Throws UsageError for a start that none has.
std::vector<ValidationCase> cie_171_cases(const std::vector<std::string>& starts);

/// What a bake has for a reading.
struct ValidationValue {
    double surface = 0.0; ///< as the field has it on the surface
    /// What a sensor 1 mm in front of the surface measures, what it should measure there, and its estimated error; with
    /// a single place and ValidationCase::exact only.
    std::optional<double> sensor;
    double sensor_exact = 0.0, sensor_error = 0.0;
};

struct ValidationResult {
    std::string name, unit;
    std::vector<ValidationReading> readings;
    std::vector<ValidationValue> values; ///< of each
    std::size_t sites = 0, rays = 0;
    double seconds = 0.0; ///< of the bake with its error estimate and readings
};

/// Bakes the case; `options.at` is replaced, and the output has no more vertices than needed if `output_spacing` is 0.
ValidationResult validate(const Registry& registry, const ValidationCase& one, const BakeOptions& options,
                          const Execution& execution);

/// |value - right| over `right`, or over a hundredth of the case's largest reading where that is more.
double validation_deviation(const ValidationResult& result, double value, double right);

/// A Markdown table, one row a case: readings; largest deviation of the surface's and of the sensors' from the exact
/// ones; rms error of the sensors over the rms of their estimated errors; largest deviation of the report's figures
/// from the exact ones, doubtful ones left out; how many sensors (where there are none, surface readings) are within 5
/// % of these; how many are doubtful. No ratio where both errors are below 1e-5 of the readings.
std::string validation_header();
std::string validation_row(const ValidationResult& result);

/// One line a reading, and the header.
std::string validation_csv_header();
std::string validation_csv_rows(const ValidationResult& result);

} // namespace difusa
