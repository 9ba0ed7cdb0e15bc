#include <difusa/bake/saved_transport.h>

#include <difusa/algebra/hit_lists.h>
#include <difusa/bake/transport_file.h>
#include <difusa/core/error.h>
#include <difusa/core/fingerprint.h>
#include <difusa/import/file_content.h>
#include <difusa/import/text_scanner.h>
#include <difusa/io/hdf5_file.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/mirrored.h>
#include <difusa/transport/pairwise.h>
#include <difusa/transport/skylight.h>
#include <difusa/version.h>

#include <algorithm>
#include <span>
#include <system_error>
#include <type_traits>
#include <utility>

namespace difusa {

namespace {

void add_vector(Fingerprint& fingerprint, const Vec3& v) {
    for (const double coordinate : v) {
        fingerprint.add(coordinate);
    }
}

/// The numbers of a list of vectors or colours, three for each.
template <class Of, class Items> std::vector<double> triples(const Items& items, const Of& of) {
    std::vector<double> numbers;
    numbers.reserve(3 * items.size());
    for (const auto& item : items) {
        const Vec3 v(of(item));
        numbers.insert(numbers.end(), v.begin(), v.end());
    }
    return numbers;
}

template <class T>
void put(Hdf5Writer& file, const std::string& path, const std::vector<T>& values, std::size_t columns,
         const std::string& meaning) {
    file.array(path, std::span<const T>(values), columns, meaning);
}

void put_moved(const std::vector<MovedObject>& moved, Hdf5Writer& file) {
    if (moved.empty()) {
        return;
    }
    std::vector<double> motions;
    for (std::size_t i = 0; i < moved.size(); ++i) {
        const RigidMotion& motion = moved[i].motion;
        for (Eigen::Index row = 0; row < 3; ++row) {
            for (Eigen::Index column = 0; column < 3; ++column) {
                motions.push_back(motion.rotation(row, column));
            }
            motions.push_back(motion.offset[row]);
        }
        const std::string number = std::to_string(i);
        file.attribute("/scene", "moved_" + number + "_object", moved[i].object);
        put(file, "/scene/moved_" + number + "_triangles", moved[i].triangles, 1, "triangles that were moved");
    }
    put(file, "/scene/motions", motions, 12,
        "of each object that was moved, in this order: the first three rows of its 4 by 4 matrix");
}

void put_scene(const SavedTransport& transport, Hdf5Writer& file) {
    file.group("/scene");
    file.attribute("/scene", "file", transport.scene);
    file.attribute("/scene", "content_fingerprint", transport.scene_content);
    file.attribute("/scene", "geometry_fingerprint", transport.geometry);
    put(file, "/scene/turned_over", transport.turned_over, 1, "triangles whose fronts were backs in the file");
    put_moved(transport.moved, file);
}

void put_lights(const BakeOptions& options, Hdf5Writer& file) {
    const auto colour = [](const std::optional<Rgb>& c) {
        return c ? std::vector<double>(c->data(), c->data() + 3) : std::vector<double>();
    };
    put(file, "/options/reflectance", colour(options.reflectance), 3,
        "of faces without a colour, R G B; no row: not given");
    put(file, "/options/sky", colour(options.sky), 3,
        "irradiance under a uniform sky, R G B, W/m^2; no row: not given");
    std::vector<double> suns, points;
    for (const Sun& sun : options.suns) {
        suns.insert(suns.end(), sun.towards.begin(), sun.towards.end());
        suns.insert(suns.end(), sun.irradiance.begin(), sun.irradiance.end());
        suns.push_back(sun.of_sky ? 1.0 : 0.0);
        file.attribute("/options", "sun_" + std::to_string(suns.size() / 7 - 1) + "_name", sun.name);
    }
    for (const PointLight& light : options.point_lights) {
        for (const Vec3& v : {light.position, Vec3(light.intensity), light.direction}) {
            points.insert(points.end(), v.begin(), v.end());
        }
        points.insert(points.end(), {light.cos_inner, light.cos_outer});
        file.attribute("/options", "point_light_" + std::to_string(points.size() / 11 - 1) + "_name", light.name);
    }
    put(file, "/options/suns", suns, 7,
        "added to those of the scene: direction towards it, irradiance R G B in W/m^2, 1 if part of the sky");
    put(file, "/options/point_lights", points, 11,
        "added to those of the scene: position, intensity R G B in W/sr, axis, cosines of the inner and outer cone");
}

void put_options(const BakeOptions& options, Hdf5Writer& file) {
    file.group("/options");
    for_saved_choices(options, [&](const char* name, const auto& value) {
        using Type = std::decay_t<decltype(value)>;
        if constexpr (std::is_integral_v<Type>) {
            file.attribute("/options", name, static_cast<std::uint64_t>(value));
        } else {
            file.attribute("/options", name, value);
        }
    });
    put_lights(options, file);
}

void put_sites(const SiteSet& sites, Hdf5Writer& file) {
    file.group("/sites");
    file.attribute("/sites", "spacing", sites.spacing);
    file.attribute("/sites", "neighbours", static_cast<std::uint64_t>(sites.neighbours));
    std::vector<Index> face;
    std::vector<double> coordinates;
    for (const SurfacePoint& site : sites.points) {
        face.push_back(site.face);
        coordinates.insert(coordinates.end(), {site.u, site.v});
    }
    put(file, "/sites/position", triples(sites.points, [](const SurfacePoint& x) { return x.position; }), 3,
        "in the unit of the scene");
    put(file, "/sites/normal", triples(sites.points, [](const SurfacePoint& x) { return x.normal; }), 3, "unit");
    put(file, "/sites/face", face, 1, "triangle each is on");
    put(file, "/sites/coordinates", coordinates, 2,
        "u and v: the site is (1-u-v) a + u b + v c of the corners a, b, c");
    put(file, "/sites/region", sites.region, 1, "smooth part of the surface each is on");
    put(file, "/sites/radius", sites.radius, 1, "distance to the neighbour of the number `neighbours`");
    put(file, "/sites/area", sites.area, 1, "effective area");
}

/// `values`: of each entry.
void put_rows(const SparseRows::Packed& packed, std::size_t values, const std::string& path, Hdf5Writer& file) {
    file.group(path);
    file.attribute(path, "columns", static_cast<std::uint64_t>(packed.columns));
    put(file, path + "/row_entries", packed.row_entries, 1, "number of entries of each row");
    put(file, path + "/column", packed.column, 1, "of each entry, row by row, ascending in each");
    put(file, path + "/value", packed.value, values, values == 1 ? "of each entry" : "of each entry, by channel");
}

void put_lists(const HitLists& lists, const std::string& path, Hdf5Writer& file) {
    const HitLists::Packed packed = lists.packed();
    file.group(path);
    file.attribute(path, "columns", static_cast<std::uint64_t>(packed.columns));
    file.attribute(path, "rays_of_a_row", static_cast<std::uint64_t>(packed.rays));
    file.attribute(path, "rows_of_a_block", static_cast<std::uint64_t>(packed.rows_per_block));
    put(file, path + "/row_bytes", packed.row_bytes, 1, "length of the code of each row");
    put(file, path + "/codes", packed.codes, 1,
        "of each row: number of hits (32 bits), parameter r (8 bits), Golomb-Rice codes of the gaps between the "
        "columns");
}

void put_mirrored(const LightTransport& gathered, const ChannelRows& rows, const std::string& path, Hdf5Writer& file) {
    const auto channels = static_cast<std::size_t>(rows.channels());
    put_rows(rows.packed(), channels, path, file);
    file.attribute(path, "channels", static_cast<std::uint64_t>(channels));
    const auto flat = [](const Values& values) {
        return std::vector<double>(values.data(), values.data() + values.size());
    };
    put(file, path + "/back", flat(gathered.back_in_mirrors), channels,
        "share of each gather point that ends on backs of faces after a mirror");
    put(file, path + "/cut_off", flat(gathered.cut_off), channels,
        "share that is reflected more often than it is followed");
}

void put_transport(const SavedTransport& transport, Hdf5Writer& file) {
    const LightTransport& gathered = transport.gathered;
    const std::string path = "/transport";
    file.group(path);
    file.attribute(path, "surfels", static_cast<std::uint64_t>(gathered.surfels));
    file.attribute(path, "sky_parts", static_cast<std::uint64_t>(SkyParts::count));
    file.attribute(path, "rays", static_cast<std::uint64_t>(gathered.rays));
    file.attribute(path, "segments", static_cast<std::uint64_t>(gathered.segments));
    file.attribute(path, "discretisation_fingerprint", transport.discretisation);
    put(file, path + "/sky", gathered.sky, 1, "share of the hemisphere of each gather point that is sky");
    put(file, path + "/back", gathered.back, 1, "share that backs of faces take");
    if (gathered.cut_off.rows() > 0 && part_in_mirrors(*gathered.W) == nullptr) {
        put(file, path + "/cut_off",
            std::vector<double>(gathered.cut_off.data(), gathered.cut_off.data() + gathered.cut_off.size()), 1,
            "share that is cut off in an infinite series of periods or parallel symmetry planes");
    }
    const LinearOperator& plain = plain_part(*gathered.W);
    if (const auto* const lists = dynamic_cast<const HitLists*>(&plain)) {
        put_lists(*lists, path + "/lists", file);
    } else {
        const SparseRows* const rows = plain.entries();
        DIFUSA_REQUIRE(rows != nullptr);
        put_rows(rows->packed(), 1, path + "/rows", file);
    }
    if (const std::shared_ptr<const ChannelRows> in_mirrors = part_in_mirrors(*gathered.W)) {
        put_mirrored(gathered, *in_mirrors, path + "/in_mirrors", file);
    }
    if (transport.form_factors) {
        put_rows(transport.form_factors->packed(), 1, path + "/form_factors", file);
    }
    if (transport.contraction) {
        const std::string group = path + "/spectral_radius";
        file.group(group);
        file.attribute(group, "value", transport.contraction->radius);
        file.attribute(group, "is_bound", std::uint64_t{transport.contraction->is_bound ? 1U : 0U});
        file.attribute(group, "reflectance_fingerprint", transport.contraction->reflectance);
        file.attribute(group, "elements", transport.elements);
    }
}

std::size_t size_of(const SparseRows& rows) {
    return rows.nonzeros() * (sizeof(Index) + sizeof(double)) + rows.rows() * sizeof(std::uint32_t);
}

} // namespace

double SavedTransport::bytes_per_site() const {
    constexpr std::size_t site = 10 * sizeof(double) + 2 * sizeof(Index), share = 2 * sizeof(double);
    std::size_t sum = sites->size() * site + gathered.points() * share;
    const LinearOperator& plain = plain_part(*gathered.W);
    if (const auto* const lists = dynamic_cast<const HitLists*>(&plain)) {
        sum += lists->code_bytes() + lists->rows() * sizeof(std::uint32_t);
    } else if (const SparseRows* const rows = plain.entries()) {
        sum += size_of(*rows);
    }
    if (const std::shared_ptr<const ChannelRows> in_mirrors = part_in_mirrors(*gathered.W)) {
        sum += in_mirrors->bytes() + 2 * sizeof(double) * static_cast<std::size_t>(gathered.cut_off.size());
    }
    if (form_factors) {
        sum += size_of(*form_factors);
    }
    return static_cast<double>(sum) / static_cast<double>(sites->size());
}

std::uint64_t geometry_fingerprint(const Mesh& mesh) {
    Fingerprint fingerprint;
    fingerprint.add(static_cast<std::uint64_t>(mesh.points.size()));
    for (const Vec3& point : mesh.points) {
        add_vector(fingerprint, point);
    }
    fingerprint.add(static_cast<std::uint64_t>(mesh.triangles.size()));
    for (const std::array<Index, 3>& triangle : mesh.triangles) {
        for (const Index corner : triangle) {
            fingerprint.add(std::uint64_t{corner});
        }
    }
    fingerprint.add(mesh.region);
    if (mesh.mirrors.any()) {
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            if (const Index kind = mesh.mirrors.kind(t); kind != none) {
                fingerprint.add(std::uint64_t{t});
                add_vector(fingerprint, Vec3(mesh.mirrors.reflectance[kind]));
            }
        }
        fingerprint.add(static_cast<std::uint64_t>(mesh.mirrors.most));
    }
    for (const Repetition::Plane& plane : mesh.repetition.planes) {
        fingerprint.add(std::uint64_t{1});
        add_vector(fingerprint, plane.normal);
        fingerprint.add(plane.normal.dot(plane.point)); // any point on it will do
    }
    for (const Vec3& period : mesh.repetition.periods) {
        fingerprint.add(std::uint64_t{2});
        add_vector(fingerprint, period);
    }
    return fingerprint.value();
}

std::uint64_t discretisation_fingerprint(const Discretisation& discretisation) {
    return discretisation_fingerprint(discretisation.points, *discretisation.surfels);
}

std::uint64_t discretisation_fingerprint(std::span<const SurfacePoint> points, const Surfels& surfels) {
    Fingerprint fingerprint;
    fingerprint.add(static_cast<std::uint64_t>(points.size()));
    for (const SurfacePoint& point : points) {
        add_vector(fingerprint, point.position);
        add_vector(fingerprint, point.normal);
        fingerprint.add(std::uint64_t{point.face});
    }
    fingerprint.add(static_cast<std::uint64_t>(surfels.size()));
    for (Index s = 0; s < surfels.size(); ++s) {
        fingerprint.add(surfels.area(s));
    }
    return fingerprint.value();
}

std::uint64_t content_fingerprint(std::span<const std::filesystem::path> files) {
    Fingerprint fingerprint;
    for (const std::filesystem::path& file : files) {
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(file, ignored)) {
            return 0;
        }
        try {
            fingerprint.add(std::string_view(read_file(file)));
        } catch (const InputError&) {
            return 0;
        }
    }
    return files.empty() ? 0 : fingerprint.value();
}

SavedTransport saved_transport_of(const BakeResult& result) {
    if (result.dry_run) {
        throw UsageError("a dry run computes no transport that could be saved");
    }
    if (!result.sites->dark.empty()) {
        throw UsageError("a transport can be saved only with sites on all of the surface, so that any light can be "
                         "shone on it: bake with BakeOptions::every_surface");
    }
    if (result.scene->mesh.glossy.any()) {
        throw UsageError("a saved transport has no place for what glossy materials reflect: bake without it, "
                         "BakeOptions::gloss");
    }
    const auto extended = [](const auto& light) { return light.is_extended(); };
    if (std::any_of(result.requested.suns.begin(), result.requested.suns.end(), extended) ||
        std::any_of(result.requested.point_lights.begin(), result.requested.point_lights.end(),
                    [&](const PointLight& light) { return light.distribution != nullptr || extended(light); })) {
        throw UsageError("a saved transport has no place for the suns with a disc and the luminaires of BakeOptions: "
                         "make them lights of the scene");
    }
    SavedTransport saved;
    std::error_code ignored;
    const std::filesystem::path file = std::filesystem::absolute(result.file, ignored);
    saved.scene_content = content_fingerprint(result.files);
    saved.scene = saved.scene_content == 0 ? result.file : file.lexically_normal().string();
    saved.geometry = geometry_fingerprint(result.scene->mesh);
    saved.discretisation = discretisation_fingerprint(result.system->discretisation());
    saved.turned_over = result.turned_over;
    saved.moved = result.moved;
    saved.options = result.requested;
    saved.options.sampler = result.options.sampler; // where none was named, that of the basis
    saved.options.spacing = result.options.spacing; // not that of `sites`, which is less where some were added
    saved.options.sites = result.options.sites;
    saved.options.adaptive = result.options.adaptive; // these, too, where an accuracy was ordered
    saved.options.rays = result.options.rays;
    saved.options.shadow_rays = result.options.shadow_rays;
    saved.options.analytic = result.options.analytic; // what was decided from the rays, which are not looked at again
    saved.options.target.reset();
    saved.sites = result.sites;
    saved.gathered = by_rays_alone(result.system->transport());
    if (PairwiseParts parts = pairwise_parts(*saved.gathered.W); parts.form_factors) {
        saved.form_factors = std::move(parts.form_factors);
        saved.gathered.W = std::move(parts.gathered);
    }
    saved.contraction = result.system->contraction();
    saved.elements = result.elements;
    return saved;
}

void write_transport(const SavedTransport& transport, WholeFile& file) {
    Hdf5Writer content(seal_size);
    content.attribute("/", "format", transport_seal().name);
    content.attribute("/", "format_version", std::uint64_t{transport_seal().version});
    content.attribute("/", "difusa_version", version());
    content.attribute("/", "byte_order", std::string("little-endian"));
    content.attribute("/", "bytes_per_site", transport.bytes_per_site());
    put_scene(transport, content);
    put_options(transport.options, content);
    put_sites(*transport.sites, content);
    put_transport(transport, content);
    write_sealed(file, transport_seal(), content.finish());
}

bool is_transport_file(const std::filesystem::path& file) {
    return lower_case(file.extension().string()) == ".difusa" || begins_as_sealed(file, transport_seal());
}

void save_transport(const BakeResult& result, const std::filesystem::path& file) {
    const SavedTransport saved = saved_transport_of(result);
    WholeFile whole(file);
    write_transport(saved, whole);
    whole.commit();
}

} // namespace difusa
