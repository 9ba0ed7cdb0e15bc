// Form factors over mirrors that are divided into patches (M 4): a path from a site to the centre of a mirror patch
// goes on reflected, over further mirrors if it meets any, to the surface. Reflected back in its mirrors it is a
// straight line, along which the ends see each other like two patches without mirrors, except that the mirror patch
// shows a part of the other end only.
#pragma once

#include <difusa/algebra/sparse_rows.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/rays/tracer.h>
#include <difusa/transport/kernel.h>

#include <array>
#include <cstddef>
#include <vector>

namespace difusa {

/// Where paths begin, and what they carry.
enum class MirrorPaths {
    gathered, ///< at the receiver, towards all mirror patches: each shows it a part of the surface
    shot,     ///< at the emitter: each patch lights a part of the surface, whose elements receive it by their share
    printed,  ///< at the emitter, with the factors of M eq. 10 and 13 for the elements where the path ends
};

struct MirrorPathOptions {
    MirrorPaths paths = MirrorPaths::gathered;
    double granularity = 1.0; ///< longest edge of the mirror patches, in spacings of the sites
    /// For each site and mirror: patches that cover more than that at the farthest surface which the mirror shows the
    /// site are quartered. Whether a patch itself shows anything does not count, or sums would miss what lies at edges.
    bool adaptive = true;

    static constexpr int most_quarterings = 5; ///< of a patch, one after the other
};

/// The solid angle of a small patch of area A at distance r whose normal is turned from the line of sight by this
/// cosine (M eq. 11).
inline double small_solid_angle(double A, double cosine, double r) {
    return A * cosine / (r * r);
}

/// The share of an emitter that a receiver sees over a chain of mirrors: A'/A of M eq. 6, by the least solid angle of
/// the chain and that of the emitter (eq. 12, 13). For one mirror patch, the form factor times this is eq. 9 and 10,
/// without their division by a cosine that may vanish; it never exceeds 1.
inline double share_in_sight(double least_of_mirrors, double of_emitter) {
    return least_of_mirrors < of_emitter ? least_of_mirrors / of_emitter : 1.0;
}

/// A part of a mirror's triangle, similar to it: centre in barycentric coordinates, and size relative to the triangle;
/// negative if it is turned by 180°.
struct MirrorPatch {
    Index triangle = none;
    double u = 0.0, v = 0.0, size = 1.0;
};

/// All mirrors in patches with no edge longer than `edge`, by triangles. Each triangle is divided into n² congruent
/// ones. Throws ResourceError if memory does not suffice for them, or as below.
std::vector<MirrorPatch> mirror_patches(const Mesh& mesh, double edge, const Execution& execution);

/// How many there would be. Throws ResourceError if they are more than 2^31.
std::size_t mirror_patch_count(const Mesh& mesh, double edge);

/// The four parts of a patch.
std::array<MirrorPatch, 4> quartered(const MirrorPatch& patch);

/// Form factors over mirrors.
struct MirroredFactors {
    std::vector<SparseRows::Row> rows; ///< #S by #S: from the receiving site to the emitting one, columns ascend
    std::size_t rays = 0;              ///< cast, with all that go on from mirrors
};

/// For grey mirrors. An element b where a path from site a ends, with the weight phi_b there, has the share
///     phi_b min(A', A_b) / A_b,   A' = omega r² / cos,
/// of the form factor between a and b along the straightened path: A' is the area that the mirror patch covers at the
/// end as seen from a, r the length of the path. As mirror patches become small, the shares of an element that is seen
/// in full sum to 1. Printed: the share of emitter a that element b sees over the path, times phi_b. With M, a vertex
/// shared by several patches receives too much and is corrected by dividing by their number; for vertices of a lattice
/// of squares that is the mean of their bilinear element over each of its patches, and the weights phi_b take its
/// place: they sum to 1 at the end of each path.
///
/// The least solid angle is over the patch where the path begins and all further mirrors: of these, printed, the
/// patches of the same granularity, otherwise the whole mirrors, since paths through all patches of the first are
/// added up and those of the others limit nothing.
MirroredFactors mirrored_factors(const Tracer& tracer, const Discretisation& discretisation, const Kernel& kernel,
                                 const MirrorPathOptions& options, const Execution& execution);

} // namespace difusa
