// Compares two baked fields, on the same mesh or on different ones.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/io/field_file.h>
#include <difusa/study/metrics.h>

#include <string>
#include <vector>

namespace difusa {

struct CompareOptions {
    std::vector<std::string> arrays; ///< point arrays to compare in addition to total and indirect light
    double max_distance = 0.0;  ///< points of the reference farther away do not match; 0: 1 % of its mesh's diameter
    bool with_emitters = false; ///< include emitting surfaces in the norms of the total light
    double least_matched = 0.5; ///< share of the result's area that must match
};

/// A quantity present in both files.
struct ComparedQuantity {
    std::string name; ///< "radiosity", "radiosity_indirect", "radiosity_weighted", or the array's
    std::string unit;
    std::vector<std::string> components; ///< names of the channels; empty for a scalar
    bool rgb = false;                    ///< the channels are R, G and B
    FieldNorms norms;                    ///< over the matched part of the result's surface
    Values result, reference;            ///< #V by #channels at the result's vertices; NaN where there is no match
};

/// How the surface of the result matches that of the reference.
struct Matching {
    bool same_mesh = false;            ///< identical points and triangles: compared vertex by vertex
    double area = 0.0;                 ///< of the result
    double reference_area = 0.0;       ///< of the reference
    double matched_area = 0.0;         ///< of the result: the domain of the norms
    double turned_away_area = 0.0;     ///< of the result: no triangle of the reference faces the same way
    double emitting_area = 0.0;        ///< of the result: matched, but left out of the norms of the total light
    double too_far_area = 0.0;         ///< of the result: the nearest such triangle is beyond the limit
    double max_distance = 0.0;         ///< the limit
    double largest_distance = 0.0;     ///< of the matched points
    std::vector<std::uint8_t> matched; ///< #V, 0 or 1
    std::vector<double> distance;      ///< #V, to the match; NaN where no triangle faces the same way
    std::size_t unmatched_vertices = 0;
};

struct Comparison {
    Matching matching;
    std::vector<ComparedQuantity> quantities;
    std::vector<std::string> notes; ///< what the user should know
};

/// Compares `result` with `reference`, both triangle meshes with values at their vertices (linear in between).
///
/// Quantities: the total light `radiosity` if both files have it, otherwise `radiosity_weighted` (or PLY's quality);
/// the indirect light `radiosity_indirect` = `irradiance_indirect` times `reflectance`; and `options.arrays`.
///
/// What emits, by the array `emission` of either file, is left out of the norms of whatever contains emitted light
/// (`radiosity`, `radiosity_weighted`, `luminance`, `radiosity_of_NAME`) unless requested, or unless nothing else is
/// there: its radiosity is known, and so much larger than what it lights that relative errors would say nothing. If
/// neither file has that array, a note says that emitters are included.
///
/// Norms are integrals over the result's triangles by the rule with the points (1/6, 1/6, 2/3) and weights of a third
/// of the area, exact for quadratic functions: for the square of an error that is linear in a triangle. Points inside
/// triangles, unlike vertices with a share of the area each, never lie on edges where the field jumps. The vertices are
/// also included in the largest error. On another mesh the reference is interpolated at its nearest point facing the
/// same way (NearestSurface), so it should be at least as fine as the result; unmatched parts are excluded from the
/// norms, and their amount is given in `matching` and in the notes.
///
/// Throws InputError if a file has no triangles, an array is missing or has a different number of components (the
/// message lists those available), nothing can be compared, values are not finite, or a smaller share of the result
/// than `options.least_matched`, or no part of it, lies on the reference; Interrupted. `result_name`, `reference_name`:
/// for messages.
Comparison compare(const FieldFile& result, const std::string& result_name, const FieldFile& reference,
                   const std::string& reference_name, const CompareOptions& options, const Execution& execution);

/// The errors on the result's mesh, for each quantity Q: `Q_error` (result - reference), `Q_error_absolute` and
/// `Q_error_relative`; of the mean weighted by luminance if Q is R G B, of the magnitudes' root sum of squares if it
/// has other components (then not negative); with more than one channel also for each of them: `Q_error_rgb` or
/// `Q_error_components` and so on. In addition `matched` (0 or 1) and `distance` to the reference's surface.
///
/// The relative error is the absolute one divided by the reference's magnitude at the point, or by 1 % of its mean
/// magnitude if that is larger: a leak into the dark is a large number, not an infinite one. NaN: no match, or an error
/// where the reference is zero everywhere.
FieldFile error_field(const Comparison& comparison, const FieldFile& result, const std::string& result_name,
                      const std::string& reference_name);

/// A table of the norms for the user.
std::string table_of(const Comparison& comparison);

/// The comparison as JSON text with the fields `schema` ("difusa-comparison") and `schema_version` (3).
std::string report_of(const Comparison& comparison, const std::string& result_name, const std::string& reference_name);

} // namespace difusa
