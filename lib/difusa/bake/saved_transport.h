// What a bake has computed of a surface alone, in a file: with it the surface is lit again, by any light and in any
// colours, without casting the rays once more (bake/relight.h). The format: data/TRANSPORT_FORMAT.md.
#pragma once

#include <difusa/algebra/sparse_rows.h>
#include <difusa/bake/options.h>
#include <difusa/bake/result.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/io/whole_file.h>
#include <difusa/radiosity/system.h>
#include <difusa/transport/light_transport.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace difusa {

struct SavedTransport {
    std::filesystem::path file;      ///< it was loaded from; empty: it was not
    std::string scene;               ///< the file that was baked, with its whole path, or the name of a program's scene
    std::uint64_t scene_content = 0; ///< fingerprint of that file and those that it names; 0: there is no file
    std::uint64_t geometry = 0;      ///< geometry_fingerprint of the surface
    std::uint64_t discretisation = 0; ///< discretisation_fingerprint
    std::vector<Index> turned_over;   ///< triangles whose fronts were backs in the file
    std::vector<MovedObject> moved;   ///< after that, in this order; `geometry` is that of the moved surface
    /// The choices of the bake, as its caller made them, with the spacing that it chose if none was given;
    /// nothing of its outputs.
    BakeOptions options;
    std::shared_ptr<const SiteSet> sites;
    LightTransport gathered;                        ///< by rays; W: HitLists or SparseRows
    std::shared_ptr<const SparseRows> form_factors; ///< of pairwise transport (transport/pairwise.h); null: gathered
    std::optional<Contraction> contraction;         ///< of the bake's equation, which holds for the same reflectances
    std::string elements;                           ///< of that equation: BakeResult::elements

    /// Size of sites and transport in the file, in bytes a site.
    double bytes_per_site() const;
};

/// Of points, triangles, regions, mirrors, symmetry planes and periods.
std::uint64_t geometry_fingerprint(const Mesh& mesh);

/// Of what the numbers of rows and columns of a transport stand for: gather points and surfels.
std::uint64_t discretisation_fingerprint(std::span<const SurfacePoint> points, const Surfels& surfels);
std::uint64_t discretisation_fingerprint(const Discretisation& discretisation);

/// Of the contents of these files, one after the other; 0 if one cannot be read, or if there are none.
std::uint64_t content_fingerprint(std::span<const std::filesystem::path> files);

/// Throws UsageError if there are no sites on some of the surface, for which the bake needs BakeOptions::every_surface,
/// for glossy materials, and for suns with a disc and luminaires among its options, which the file cannot hold.
SavedTransport saved_transport_of(const BakeResult& result);

/// Writes the file; the caller commits it. Throws ResourceError.
void write_transport(const SavedTransport& transport, WholeFile& file);

/// Completely or not at all.
void save_transport(const BakeResult& result, const std::filesystem::path& file);

/// Whether a file is meant to be a saved transport, by its name (.difusa) or its beginning; loading it may fail all the
/// same.
bool is_transport_file(const std::filesystem::path& file);

/// Throws InputError, with the reason and the remedy, for anything but a complete and undamaged file of this version of
/// the format whose numbers are sound; ResourceError if it does not fit into memory.
SavedTransport load_transport(const std::filesystem::path& file, const Execution& execution);

} // namespace difusa
