// Form factors between the triangles of a surface with far ones in groups: as many numbers as an accuracy takes,
// instead of one for each pair.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/form_factors/form_factors.h>
#include <difusa/mesh/mesh.h>

#include <cstddef>
#include <vector>

namespace difusa {

/// The kernel cos cos / (pi r²) between points that see each other as a product of linear functions for each pair of
/// groups: for triangles i of group a and j of group b, or the other way round, if a and b are linked,
///     F_ij = A_j k (1 + g_a · (c_i - c_a)) (1 + g_b · (c_j - c_b))
/// with the centroids c of triangles and groups, which is reciprocal. Each pair of triangles belongs to one link at
/// most, and to none where they do not see each other. (Hanrahan, Salzman and Aupperle 1991, where the kernel is
/// constant.)
struct GroupedFormFactors {
    struct Group {
        Index first = 0, last = 0; ///< its triangles are order[first] to order[last - 1]
        Index right = none;        ///< none: one triangle; otherwise its halves are the next group and this one
        double area = 0.0;
        Vec3 centre = Vec3::Zero(); ///< centroid
    };
    struct Link {
        Index a = none, b = none;
        double kernel = 0.0;                                     ///< k, 1 over an area: A_a F_ab = k A_a A_b
        Vec3 gradient_a = Vec3::Zero(), gradient_b = gradient_a; ///< g, 1 over a length, in the planes of the groups
        float error = 0.0F; ///< estimated, absolute, of the factors from any triangle of one group to all of the other
    };
    std::vector<Index> order;  ///< #triangles
    std::vector<Group> groups; ///< from the whole surface down, each before its parts
    std::vector<Link> links;
    std::vector<double> area;   ///< #triangles
    std::vector<Vec3> centroid; ///< #triangles

    /// sum_j F_ij of each triangle.
    std::vector<double> row_sums() const;

    /// The sums of the estimated errors of what the rows are the sums of.
    std::vector<double> row_errors() const;
};

/// Groups are nodes of a binary tree, flat wherever the surface is, down to single triangles. Two groups become a link
/// where each is flat and in front of the other, and the estimated error of the factors from any triangle of the one to
/// all of the other is at most a tenth of the tolerance, since errors of a row add up, and 3 % of the factor if nothing
/// is in between; otherwise the one with the larger radius is divided. Two triangles are linked by PairExchange::of, as
/// single ones are.
///
/// The kernel of groups with nothing in between is fitted to its means over the one from points of the other, by the
/// rule of five points that is exact for cubic polynomials on a rectangle: the centroid, and a distance of √3 standard
/// deviations of the area from it along both principal axes, with weights of 1/3 and 1/6. The error is what the second
/// differences say of a quadratic function, and by how much gradients are limited so that no factor is negative.
/// Between groups with something in between the pairs of points are tested one by one, and the kernel is that of pairs
/// that see each other; the smaller of the hidden and visible shares of the factor, but at least an eighth, is added to
/// the error.
///
/// The same bits for any number of threads. Journal and progress: phase "form factors".
/// Throws UsageError if the tolerance is not positive, Interrupted if cancelled.
GroupedFormFactors grouped_form_factors(const Mesh& mesh, const FormFactorOptions& options, const Execution& execution,
                                        FormFactorCounts* counts = nullptr);

} // namespace difusa
