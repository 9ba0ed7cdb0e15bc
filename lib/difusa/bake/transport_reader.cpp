#include <difusa/bake/saved_transport.h>

#include <difusa/algebra/hit_lists.h>
#include <difusa/bake/transport_file.h>
#include <difusa/core/error.h>
#include <difusa/io/hdf5_file.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/mirrored.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

namespace difusa {

namespace {

/// Reads one file, group by group.
class TransportReader {
  public:
    TransportReader(const std::filesystem::path& name, const Execution& execution)
        : file_(read_sealed(name, transport_seal()), name, transport_seal().remedy), name_(name),
          execution_(execution) {}

    SavedTransport read() {
        if (file_.text("/", "byte_order") != "little-endian" ||
            file_.whole("/", "format_version") != transport_seal().version) {
            file_.refuse("/", "states another byte order or version");
        }
        saved_.file = name_;
        saved_.scene = file_.text("/scene", "file");
        saved_.scene_content = file_.whole("/scene", "content_fingerprint");
        saved_.geometry = file_.whole("/scene", "geometry_fingerprint");
        saved_.turned_over = file_.array<std::uint32_t>("/scene/turned_over", 1);
        read_moved();
        read_options();
        read_sites();
        read_transport();
        read_contraction("/transport/spectral_radius");
        return std::move(saved_);
    }

  private:
    template <class T> T whole(const std::string& group, const std::string& name, T least, T most) const {
        const std::uint64_t value = file_.whole(group, name);
        if (value < static_cast<std::uint64_t>(least) || value > static_cast<std::uint64_t>(most)) {
            file_.refuse(group + " " + name, "is out of its range");
        }
        return static_cast<T>(value);
    }

    std::vector<double> shares(const std::string& path, std::size_t rows) const {
        std::vector<double> values = file_.array<double>(path, 1, rows);
        if (!std::all_of(values.begin(), values.end(), [](double v) { return v >= 0.0 && v <= 1.0 + 1e-9; })) {
            file_.refuse(path, "has a share that is not from 0 to 1");
        }
        return values;
    }

    std::vector<double> finite(const std::string& path, std::size_t columns, std::size_t rows) const {
        std::vector<double> values = file_.array<double>(path, columns, rows);
        if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) {
            file_.refuse(path, "has a number that is not finite");
        }
        return values;
    }

    std::optional<Rgb> colour(const std::string& path) const {
        const std::vector<double> values = file_.array<double>(path, 3);
        if (values.size() > 3) {
            file_.refuse(path, "has several rows");
        }
        return values.empty() ? std::nullopt : std::optional(Rgb(values[0], values[1], values[2]));
    }

    void read_moved() {
        const std::string path = "/scene/motions";
        if (!file_.has(path)) {
            return;
        }
        const std::vector<double> motions = file_.array<double>(path, 12);
        for (std::size_t i = 0; 12 * i < motions.size(); ++i) {
            const std::string name = "moved_" + std::to_string(i);
            MovedObject moved{file_.text("/scene", name + "_object"),
                              {},
                              file_.array<std::uint32_t>("/scene/" + name + "_triangles", 1)};
            const double* const n = motions.data() + 12 * i;
            for (Eigen::Index row = 0; row < 3; ++row) {
                moved.motion.rotation.row(row) = Eigen::Map<const Eigen::RowVector3d>(n + 4 * row);
                moved.motion.offset[row] = n[4 * row + 3];
            }
            if (!is_rigid(moved.motion)) {
                file_.refuse(path, "has a motion that is not rigid");
            }
            saved_.moved.push_back(std::move(moved));
        }
    }

    void read_options() {
        BakeOptions& options = saved_.options;
        for_saved_choices(options, [&](const char* name, auto& value) {
            using Type = std::decay_t<decltype(value)>;
            if constexpr (std::is_same_v<Type, std::string>) {
                value = file_.text("/options", name);
            } else if constexpr (std::is_floating_point_v<Type>) {
                value = file_.number("/options", name);
            } else {
                value = whole<Type>("/options", name, 0, std::numeric_limits<Type>::max());
            }
        });
        read_lights(options);
        options.every_surface = true;
        BakeOptions sound = options; // a bake has been given one of the two, and stored both
        sound.sites = 0;
        try {
            check_options(sound);
        } catch (const UsageError& error) {
            file_.refuse("/options", std::string("is not sound (") + error.what() + ")");
        }
    }

    void read_lights(BakeOptions& options) const {
        options.reflectance = colour("/options/reflectance");
        options.sky = colour("/options/sky");
        const std::vector<double> suns = file_.array<double>("/options/suns", 7);
        for (std::size_t i = 0; i < suns.size(); i += 7) {
            const double* const n = suns.data() + i;
            options.suns.push_back({Vec3(n[0], n[1], n[2]), Rgb(n[3], n[4], n[5]),
                                    file_.text("/options", "sun_" + std::to_string(i / 7) + "_name"), n[6] != 0.0});
        }
        const std::vector<double> points = file_.array<double>("/options/point_lights", 11);
        for (std::size_t i = 0; i < points.size(); i += 11) {
            const double* const n = points.data() + i;
            options.point_lights.push_back({Vec3(n[0], n[1], n[2]), Rgb(n[3], n[4], n[5]), Vec3(n[6], n[7], n[8]), n[9],
                                            n[10],
                                            file_.text("/options", "point_light_" + std::to_string(i / 11) + "_name")});
        }
    }

    void read_sites() {
        auto sites = std::make_shared<SiteSet>();
        sites->spacing = file_.number("/sites", "spacing");
        sites->neighbours = whole<int>("/sites", "neighbours", 1, 1000);
        sites->graded = saved_.options.adaptive;
        sites->region = file_.array<std::uint32_t>("/sites/region", 1);
        const std::size_t n = sites->region.size();
        const std::vector<Index> face = file_.array<std::uint32_t>("/sites/face", 1, n);
        const std::vector<double> position = finite("/sites/position", 3, n), normal = finite("/sites/normal", 3, n),
                                  coordinates = finite("/sites/coordinates", 2, n);
        sites->radius = finite("/sites/radius", 1, n);
        sites->area = finite("/sites/area", 1, n);
        if (n == 0 || !(sites->spacing > 0.0) || !(saved_.options.spacing > 0.0)) {
            file_.refuse("/sites", "has no sites, or no spacing");
        }
        for (std::size_t i = 0; i < n; ++i) {
            const double *const p = position.data() + 3 * i, *const d = normal.data() + 3 * i;
            SurfacePoint site{Vec3(p[0], p[1], p[2]), Vec3(d[0], d[1], d[2]), face[i], coordinates[2 * i],
                              coordinates[2 * i + 1]};
            constexpr double rounding = 1e-9;
            if (!(std::abs(site.normal.norm() - 1.0) <= rounding) || !(sites->radius[i] > 0.0) ||
                (!saved_.options.adaptive && !(sites->radius[i] >= sites->spacing)) ||
                !(site.u >= -rounding && site.v >= -rounding && site.u + site.v <= 1.0 + rounding)) {
                file_.refuse("/sites",
                             "has a site, number " + std::to_string(i) +
                                 ", without a unit normal, outside of its triangle, or of too small a radius");
            }
            sites->points.push_back(site);
        }
        saved_.sites = std::move(sites);
    }

    void read_transport() {
        const std::string path = "/transport";
        LightTransport& gathered = saved_.gathered;
        saved_.discretisation = file_.whole(path, "discretisation_fingerprint");
        gathered.surfels = whole<std::size_t>(path, "surfels", 1, std::size_t{1} << 31U);
        gathered.rays = whole<std::size_t>(path, "rays", 1, std::numeric_limits<std::size_t>::max());
        gathered.segments = file_.whole(path, "segments");
        if (file_.whole(path, "sky_parts") != SkyParts::count) {
            file_.refuse(path, "divides the sky into another number of parts");
        }
        if (file_.has(path + "/lists")) {
            read_lists(path + "/lists");
        } else {
            const std::shared_ptr<const SparseRows> rows = read_rows(path + "/rows");
            gathered.bytes = rows->bytes();
            gathered.W = rows;
        }
        if (file_.has(path + "/in_mirrors")) {
            read_mirrored(path + "/in_mirrors");
        }
        constexpr std::size_t most_rays = std::size_t{1} << 25U; // of a point
        const std::size_t points = gathered.points();
        if (points < saved_.sites->size() || gathered.rays % points != 0 || gathered.rays / points > most_rays ||
            gathered.W->columns() != gathered.surfels + SkyParts::count) {
            file_.refuse(path, "does not have the size of its sites, rays, surfels and parts of the sky");
        }
        gathered.sky = shares(path + "/sky", points);
        gathered.back = shares(path + "/back", points);
        if (const std::string cut_off = path + "/cut_off"; file_.has(cut_off)) {
            if (gathered.cut_off.rows() > 0) {
                file_.refuse(cut_off, "is given with that of mirrors");
            }
            const auto rows = static_cast<Eigen::Index>(points);
            gathered.cut_off = Eigen::Map<const Values>(shares(cut_off, points).data(), rows, 1);
            gathered.back_in_mirrors.setZero(rows, 1);
        }
        if (file_.has(path + "/form_factors")) {
            saved_.form_factors = read_rows(path + "/form_factors");
            gathered.bytes += saved_.form_factors->bytes();
            const std::size_t n = saved_.sites->size();
            if (saved_.form_factors->rows() != n || saved_.form_factors->columns() != n || points != n) {
                file_.refuse(path + "/form_factors", "does not have a row and a column for each site");
            }
        }
        if (saved_.form_factors == nullptr && saved_.options.transport.rfind("pairwise", 0) == 0) {
            file_.refuse(path + "/form_factors", "is missing");
        }
    }

    void read_contraction(const std::string& path) {
        if (!file_.has(path)) {
            return;
        }
        Contraction& contraction = saved_.contraction.emplace();
        contraction.radius = file_.number(path, "value");
        contraction.is_bound = whole<int>(path, "is_bound", 0, 1) != 0;
        contraction.reflectance = file_.whole(path, "reflectance_fingerprint");
        saved_.elements = file_.text(path, "elements");
        if (!(contraction.radius >= 0.0 && contraction.radius < 1.0)) {
            file_.refuse(path, "is not from 0 to 1");
        }
    }

    void read_lists(const std::string& path) {
        HitLists::Packed packed;
        packed.columns = whole<std::size_t>(path, "columns", 1, none - 1);
        packed.rays = whole<std::size_t>(path, "rays_of_a_row", 1, none);
        packed.rows_per_block = whole<std::size_t>(path, "rows_of_a_block", 1, none);
        packed.row_bytes = file_.array<std::uint32_t>(path + "/row_bytes", 1);
        packed.codes = file_.array<std::uint8_t>(path + "/codes", 1);
        try {
            const auto lists = std::make_shared<HitLists>(packed, execution_);
            saved_.gathered.bytes = lists->bytes();
            saved_.gathered.W = lists;
        } catch (const InputError& error) {
            file_.refuse(path, std::string("is not sound: ") + error.what());
        }
        if (saved_.gathered.rays != packed.row_bytes.size() * packed.rays) {
            file_.refuse(path, "is not of as many rays as the transport");
        }
    }

    /// `values`: of each entry.
    void read_packed(const std::string& path, std::size_t values, SparseRows::Packed& packed) const {
        packed.columns = whole<std::size_t>(path, "columns", 1, none - 1);
        packed.row_entries = file_.array<std::uint32_t>(path + "/row_entries", 1);
        packed.column = file_.array<std::uint32_t>(path + "/column", 1);
        packed.value = file_.array<double>(path + "/value", values);
    }

    /// After the plain part.
    void read_mirrored(const std::string& path) {
        ChannelRows::Packed packed;
        packed.channels = whole<int>(path, "channels", 1, 3);
        const auto channels = static_cast<std::size_t>(packed.channels);
        read_packed(path, channels, packed);
        LightTransport& gathered = saved_.gathered;
        std::shared_ptr<const ChannelRows> rows;
        try {
            rows = std::make_shared<ChannelRows>(packed);
        } catch (const InputError& error) {
            file_.refuse(path, std::string("is not sound: ") + error.what());
        }
        if (rows->rows() != gathered.W->rows() || rows->columns() != gathered.W->columns()) {
            file_.refuse(path, "does not have the size of the transport");
        }
        const auto by_channel = [&](const std::string& name) {
            const std::vector<double> values = finite(path + name, channels, rows->rows());
            return Values(Eigen::Map<const Values>(values.data(), static_cast<Eigen::Index>(rows->rows()),
                                                   static_cast<Eigen::Index>(channels)));
        };
        gathered.back_in_mirrors = by_channel("/back");
        gathered.cut_off = by_channel("/cut_off");
        gathered.bytes += rows->bytes();
        gathered.W = std::make_shared<MirroredTransport>(gathered.W, std::move(rows));
    }

    std::shared_ptr<const SparseRows> read_rows(const std::string& path) const {
        SparseRows::Packed packed;
        read_packed(path, 1, packed);
        try {
            return std::make_shared<SparseRows>(packed);
        } catch (const InputError& error) {
            file_.refuse(path, std::string("is not sound: ") + error.what());
        }
    }

    Hdf5Reader file_;
    std::filesystem::path name_;
    const Execution& execution_;
    SavedTransport saved_;
};

} // namespace

SavedTransport load_transport(const std::filesystem::path& file, const Execution& execution) {
    execution.phase("load transport");
    return TransportReader(file, execution).read();
}

} // namespace difusa
