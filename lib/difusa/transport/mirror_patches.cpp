#include <difusa/transport/mirror_patches.h>

#include <difusa/core/error.h>
#include <difusa/core/memory.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

namespace difusa {

namespace {

constexpr double most_mirror_patches = 0x1p31;
constexpr const char* coarser_patches = "give a larger --spacing, or a larger granularity of mirror patches";

double longest_edge(const Mesh& mesh, Index triangle) {
    const auto [a, b, c] = mesh.corners(triangle);
    return std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
}

/// The number of parts along each edge of a triangle.
double parts_along(const Mesh& mesh, Index triangle, double edge) {
    return std::max(1.0, std::ceil(longest_edge(mesh, triangle) / edge));
}

/// For each mirror's triangle the area that it stands for where a path meets it after another mirror.
std::vector<double> areas_met(const Mesh& mesh, MirrorPaths paths, double edge) {
    std::vector<double> of_region(mesh.region_count, 0.0), area(mesh.triangles.size(), 0.0);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (mesh.mirrors.kind(t) != none) {
            of_region[mesh.region[t]] += mesh.areas[t];
        }
    }
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (mesh.mirrors.kind(t) != none) {
            const double parts = parts_along(mesh, t, edge);
            area[t] = paths == MirrorPaths::printed ? mesh.areas[t] / (parts * parts) : of_region[mesh.region[t]];
        }
    }
    return area;
}

/// A mirror that a path has met.
struct MetMirror {
    double area = 0.0; ///< projected onto the path
    double way = 0.0;  ///< length of the path up to there
};

using FactorEntry = std::pair<Index, double>;

/// A path on its way: p -> linear p + shift is the image of what it sees, reflected in all mirrors up to here.
struct MirrorPath {
    MirrorPatch patch;
    Ray ray; ///< the next part of it; its direction is unit
    std::vector<MetMirror> met;
    double reflectance = 1.0;
    double length = 0.0;
    Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
    Vec3 shift = Vec3::Zero();
};

/// All paths from one site at a time. Scratch of one thread.
class MirrorPathTracer {
  public:
    MirrorPathTracer(const Tracer& tracer, const Discretisation& discretisation, const Kernel& kernel,
                     const MirrorPathOptions& options, const std::vector<MirrorPatch>& patches,
                     const std::vector<double>& areas)
        : tracer_(tracer), mesh_(tracer.mesh()), discretisation_(discretisation), sites_(*discretisation.sites),
          kernel_(kernel), options_(options), patches_(patches), areas_met_(areas),
          largest_(0.5 * std::pow(options.granularity * sites_.spacing, 2)) {}

    /// The entries between site a and the elements where its paths end, in no order; those of an element more than
    /// once.
    void follow(Index a, std::vector<FactorEntry>& entries) {
        entries_ = &entries;
        entries.clear();
        a_ = a;
        from_ = inset(mesh_, sites_.points[a]);
        reach_.assign(mesh_.triangles.size(), 0.0);
        if (options_.adaptive) {
            probing_ = true;
            trace();
            probing_ = false;
        }
        trace();
    }

    std::size_t rays() const { return rays_cast_; }

  private:
    /// All paths: with what they carry, or if `probing_`, for what they reach.
    void trace() {
        paths_.clear();
        for (const MirrorPatch& patch : patches_) {
            begin(patch, MirrorPathOptions::most_quarterings);
        }
        cast();
        reflect_first();
        while (!paths_.empty()) {
            cast();
            arrive();
        }
    }

    /// Towards a patch, or its parts if it covers too much at the farthest surface that its triangle shows.
    void begin(const MirrorPatch& patch, int quarterings) {
        const Vec3 way = mesh_.at(patch.triangle, patch.u, patch.v).position - from_.position;
        const double distance = way.norm(), cosine = -mesh_.normals[patch.triangle].dot(way) / distance;
        if (quarterings > 0 && small_solid_angle(area_of(patch), std::max(0.0, cosine), distance) *
                                       reach_[patch.triangle] * reach_[patch.triangle] >
                                   largest_) {
            for (const MirrorPatch& quarter : quartered(patch)) {
                begin(quarter, quarterings - 1);
            }
        } else if (from_.normal.dot(way) > 0.0 && cosine > 0.0) {
            paths_.emplace_back();
            paths_.back().patch = patch;
            paths_.back().ray = {from_.position, way / distance, from_.face};
        }
    }

    double area_of(const MirrorPatch& patch) const { return mesh_.areas[patch.triangle] * patch.size * patch.size; }

    void cast() {
        rays_.clear();
        for (const MirrorPath& path : paths_) {
            rays_.push_back(path.ray);
        }
        hits_.resize(rays_.size());
        tracer_.first_hits(rays_, hits_);
        rays_cast_ += rays_.size();
    }

    /// Keeps the paths that have met the patch they began towards.
    void reflect_first() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < paths_.size(); ++i) {
            MirrorPath& path = paths_[i];
            if (hits_[i].face == path.patch.triangle && hits_[i].front) {
                reflect(path, hits_[i], area_of(path.patch));
                if (kept != i) {
                    paths_[kept] = std::move(path);
                }
                ++kept;
            }
        }
        paths_.resize(kept);
    }

    void reflect(MirrorPath& path, const Hit& hit, double area) const {
        const Vec3& n = mesh_.normals[hit.face];
        path.length += hit.t;
        path.met.push_back({area * -n.dot(path.ray.direction), path.length});
        path.reflectance *= mesh_.mirrors.reflectance[mesh_.mirrors.of_face[hit.face]][0];
        const Vec3 reflected_shift = 2.0 * n.dot(mesh_.corner(hit.face, 0)) * n;
        path.shift += path.linear * reflected_shift;
        path.linear = path.linear * (Eigen::Matrix3d::Identity() - 2.0 * n * n.transpose());
        path.ray = reflected_ray(mesh_, hit, path.ray.direction);
    }

    /// The ends of reflected paths: surfaces have their share, and mirrors reflect them on.
    void arrive() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < paths_.size(); ++i) {
            MirrorPath& path = paths_[i];
            const Hit& hit = hits_[i];
            if (hit.face == none || !hit.front) {
                continue;
            }
            const double length = path.length + hit.t;
            if (probing_) {
                double& reach = reach_[path.patch.triangle];
                reach = std::max(reach, length);
            } else {
                add_entries(path, hit, length);
            }
            const Index kind = mesh_.mirrors.kind(hit.face);
            if (kind != none && path.met.size() < mesh_.mirrors.most && mesh_.mirrors.reflectance[kind][0] > 0.0) {
                reflect(path, hit, areas_met_[hit.face]);
                if (kept != i) {
                    paths_[kept] = std::move(path);
                }
                ++kept;
            }
        }
        paths_.resize(kept);
    }

    void add_entries(const MirrorPath& path, const Hit& hit, double length) {
        const bool printed = options_.paths == MirrorPaths::printed;
        double least = std::numeric_limits<double>::infinity(); // as seen from the site, or printed, from the end
        for (const MetMirror& mirror : path.met) {
            least = std::min(least, small_solid_angle(mirror.area, 1.0, printed ? length - mirror.way : mirror.way));
        }
        discretisation_.basis->evaluate(mesh_.at(hit.face, hit.u, hit.v), row_);
        const SurfacePoint& x = sites_.points[a_];
        const double A_a = sites_.area[a_];
        const double cosine = -mesh_.normals[hit.face].dot(path.ray.direction);
        const double cosine_a = from_.normal.dot(path.linear * path.ray.direction);
        for (std::size_t i = 0; i < row_.element.size(); ++i) {
            const Index b = row_.element[i];
            const double A_b = sites_.area[b];
            if (!(A_a > 0.0 && A_b > 0.0)) {
                continue;
            }
            const Vec3 place = path.linear * sites_.points[b].position + path.shift;
            const Vec3 normal = path.linear * sites_.points[b].normal;
            const double form_factor = options_.paths == MirrorPaths::gathered
                                           ? kernel_.form_factor(x.position, x.normal, place, normal, A_b)
                                           : kernel_.form_factor(place, normal, x.position, x.normal, A_a);
            const double of_other =
                printed ? small_solid_angle(A_a, cosine_a, length) : small_solid_angle(A_b, cosine, length);
            entries_->emplace_back(b,
                                   row_.weight[i] * path.reflectance * share_in_sight(least, of_other) * form_factor);
        }
    }

    const Tracer& tracer_;
    const Mesh& mesh_;
    const Discretisation& discretisation_;
    const SiteSet& sites_;
    const Kernel& kernel_;
    const MirrorPathOptions& options_;
    const std::vector<MirrorPatch>& patches_;
    const std::vector<double>& areas_met_;
    double largest_;            ///< area that a patch may cover across the end of a path, if adaptive
    std::vector<double> reach_; ///< for each mirror's triangle, the length of the longest path over it; 0: unknown
    bool probing_ = false;

    Index a_ = none;
    SurfacePoint from_;
    std::vector<FactorEntry>* entries_ = nullptr;
    std::vector<MirrorPath> paths_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
    BasisRow row_;
    std::size_t rays_cast_ = 0;
};

/// Sums by column.
void merge(std::vector<FactorEntry>& entries) {
    std::stable_sort(entries.begin(), entries.end(),
                     [](const FactorEntry& a, const FactorEntry& b) { return a.first < b.first; });
    std::size_t last = 0;
    for (std::size_t i = 1; i < entries.size(); ++i) {
        if (entries[i].first == entries[last].first) {
            entries[last].second += entries[i].second;
        } else {
            entries[++last] = entries[i];
        }
    }
    entries.resize(std::min(entries.size(), last + 1));
}

} // namespace

std::vector<MirrorPatch> mirror_patches(const Mesh& mesh, double edge, const Execution& execution) {
    const std::size_t count = mirror_patch_count(mesh, edge);
    require_memory(static_cast<double>(count * sizeof(MirrorPatch)), execution.memory_left(),
                   "the division of the mirrors into " + std::to_string(count) + " patches", coarser_patches);
    std::vector<MirrorPatch> patches;
    patches.reserve(count);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (mesh.mirrors.kind(t) == none) {
            continue;
        }
        const double n = parts_along(mesh, t, edge);
        for (double i = 0.0; i < n; ++i) {
            for (double j = 0.0; i + j < n; ++j) {
                patches.push_back({t, (i + 1.0 / 3.0) / n, (j + 1.0 / 3.0) / n, 1.0 / n});
                if (i + j + 1.0 < n) {
                    patches.push_back({t, (i + 2.0 / 3.0) / n, (j + 2.0 / 3.0) / n, -1.0 / n});
                }
            }
        }
    }
    return patches;
}

std::size_t mirror_patch_count(const Mesh& mesh, double edge) {
    double count = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        count += mesh.mirrors.kind(t) != none ? std::pow(parts_along(mesh, t, edge), 2) : 0.0;
    }
    if (!(count < most_mirror_patches)) {
        throw ResourceError("the mirrors would be divided into " + text_of(count) + " patches of " + text_of(edge) +
                            ", more than 2^31: " + coarser_patches);
    }
    return static_cast<std::size_t>(count);
}

std::array<MirrorPatch, 4> quartered(const MirrorPatch& patch) {
    const double half = 0.5 * patch.size, near = half / 3.0, far = 2.0 * near;
    return {{{patch.triangle, patch.u, patch.v, -half},
             {patch.triangle, patch.u - near, patch.v - near, half},
             {patch.triangle, patch.u + far, patch.v - near, half},
             {patch.triangle, patch.u - near, patch.v + far, half}}};
}

MirroredFactors mirrored_factors(const Tracer& tracer, const Discretisation& discretisation, const Kernel& kernel,
                                 const MirrorPathOptions& options, const Execution& execution) {
    const Mesh& mesh = tracer.mesh();
    DIFUSA_REQUIRE(mesh.mirrors.is_grey());
    const std::size_t n = discretisation.sites->size();
    const double edge = options.granularity * discretisation.sites->spacing;
    const std::vector<MirrorPatch> patches = mirror_patches(mesh, edge, execution);
    const std::vector<double> areas = areas_met(mesh, options.paths, edge);
    MirroredFactors factors;
    std::vector<std::vector<FactorEntry>> entries(n); // of each site where paths begin
    std::vector<std::size_t> cast(n, 0);
    parallel_for(n, 1, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        MirrorPathTracer paths(tracer, discretisation, kernel, options, patches, areas);
        std::vector<FactorEntry> all; // far more than different ones
        for (std::size_t a = begin; a < end; ++a) {
            paths.follow(static_cast<Index>(a), all);
            merge(all);
            entries[a].assign(all.begin(), all.end());
        }
        cast[begin] = paths.rays();
    });
    factors.rows.resize(n);
    for (std::size_t a = 0; a < n; ++a) {
        factors.rays += cast[a];
        for (const auto& [b, value] : entries[a]) {
            const bool receives = options.paths == MirrorPaths::gathered;
            SparseRows::Row& row = factors.rows[receives ? a : b];
            row.column.push_back(receives ? b : static_cast<Index>(a));
            row.value.push_back(value);
        }
        entries[a] = {};
    }
    return factors;
}

} // namespace difusa
