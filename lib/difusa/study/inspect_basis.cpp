#include <difusa/bake/choices.h>
#include <difusa/study/inspect_basis.h>

#include <difusa/bake/scene.h>
#include <difusa/core/error.h>
#include <difusa/core/memory.h>
#include <difusa/core/parallel.h>
#include <difusa/core/random.h>
#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/basis_averages.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/mesh/point_tree.h>
#include <difusa/rays/visibility.h>
#include <difusa/rays/visibility_choice.h>
#include <difusa/scene/scene.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>

namespace difusa {

namespace {

constexpr double output_in_spacings = 1.0 / 6.0;
constexpr std::size_t site_bytes = 400;   ///< while a site is placed and linked to its neighbours
constexpr std::size_t output_bytes = 500; ///< per output triangle, including its share of vertices and arrays

/// Search trees of the sites, one per region.
class NearestSites {
  public:
    NearestSites(const Mesh& mesh, const SiteSet& sites) : mesh_(mesh), sites_(sites), all_(sites.points) {
        std::vector<std::vector<Index>> members(mesh.region_count);
        for (Index i = 0; i < sites.size(); ++i) {
            members[sites.region[i]].push_back(i);
        }
        for (std::vector<Index>& region : members) {
            of_region_.emplace_back(sites.points, std::move(region));
        }
    }

    /// The site nearest in space.
    Index in_space(const Vec3& p) const { return all_.nearest(p); }

    /// The site at the smallest site distance from x; if all are at an infinite one, the nearest in space, within the
    /// region if it has sites.
    Index of(const SurfacePoint& x) const {
        const Index region = mesh_.region[x.face];
        const PointTree& tree = of_region_[region];
        if (tree.size() == 0) {
            return in_space(x.position);
        }
        std::vector<Index> found;
        std::vector<double> squared;
        // No site distance is below the Euclidean one: the search ends once the smallest is within the range searched.
        for (std::size_t k = 8;; k *= 4) {
            k = std::min(k, tree.size());
            found.resize(k);
            squared.resize(k);
            tree.nearest(x.position, found, squared);
            double least = std::numeric_limits<double>::infinity();
            Index nearest = found[0];
            for (const Index i : found) {
                const SurfacePoint& site = sites_.points[i];
                const double d =
                    site_distance(x.position, x.normal, region, site.position, site.normal, sites_.region[i]);
                if (d < least) {
                    least = d;
                    nearest = i;
                }
            }
            if (k == tree.size() || least * least <= squared.back()) {
                return nearest;
            }
        }
    }

  private:
    const Mesh& mesh_;
    const SiteSet& sites_;
    std::vector<PointTree> of_region_; ///< empty where the region has no site
    PointTree all_;
};

void check_options(const InspectOptions& options) {
    if (options.spacing < 0.0 || !std::isfinite(options.spacing)) {
        throw UsageError("--spacing: must be a positive length");
    }
    if (options.spacing > 0.0 && options.sites > 0) {
        throw UsageError("--sites: give either --spacing or --sites, not both");
    }
    if (options.neighbours < 1 || options.neighbours > 1000) {
        throw UsageError("--neighbours: must be from 1 to 1000");
    }
    if (options.output_spacing < 0.0 || !std::isfinite(options.output_spacing)) {
        throw UsageError("--output-spacing: must be a positive length");
    }
    if (std::any_of(options.near.begin(), options.near.end(), [](const Vec3& p) { return !p.allFinite(); })) {
        throw UsageError("--near: must be a point");
    }
}

void place_sites(BasisInspection& result, const Sampler& sampler, const Visibility* rays, const Execution& execution) {
    InspectOptions& options = result.options;
    const std::size_t limit = execution.memory_left() / site_bytes;
    if (options.spacing == 0.0) {
        options.sites = options.sites == 0 ? default_sites : options.sites;
        if (options.sites > limit) {
            throw ResourceError(std::to_string(options.sites) + " sites are requested, but memory suffices for only " +
                                std::to_string(limit) + ": give fewer --sites");
        }
        options.spacing = spacing_for_count(sampler, result.mesh, rays, options.sites, options.seed, execution);
    }
    std::vector<SurfacePoint> points =
        sampler.sample(result.mesh, rays, options.spacing, limit, RandomStream(options.seed, "sites"), execution);
    result.sites = make_site_set(result.mesh, std::move(points), options.spacing, options.neighbours, execution);
}

Vec3 centroid(const Mesh& mesh) {
    Vec3 sum = Vec3::Zero();
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        sum += mesh.areas[t] / mesh.area * mesh.at(t, 1.0 / 3.0, 1.0 / 3.0).position;
    }
    return sum;
}

/// The requested elements, each once, in the order requested.
std::vector<Index> choose_elements(const BasisInspection& result, const NearestSites& nearest) {
    std::vector<Index> chosen;
    const auto choose = [&](Index element) {
        if (std::find(chosen.begin(), chosen.end(), element) == chosen.end()) {
            chosen.push_back(element);
        }
    };
    for (const Index element : result.options.elements) {
        if (element >= result.sites.size()) {
            throw UsageError("--element " + std::to_string(element) + ": there is no such element; they are numbered " +
                             "from 0 to " + std::to_string(result.sites.size() - 1) +
                             " (or give a point, --near X,Y,Z)");
        }
        choose(element);
    }
    for (const Vec3& p : result.options.near) {
        choose(nearest.in_space(p));
    }
    if (chosen.empty()) {
        choose(nearest.in_space(centroid(result.mesh)));
    }
    return chosen;
}

void evaluate_vertices(BasisInspection& result, const Basis& basis, const NearestSites& nearest,
                       const Execution& execution) {
    const std::vector<SurfacePoint>& vertices = result.output.vertices;
    const std::size_t count = vertices.size(), n = result.sites.size();
    result.phi = Values::Zero(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(result.elements.size()));
    result.sum.assign(count, 0.0);
    result.lebesgue.assign(count, 0.0);
    result.overlap.assign(count, 0);
    result.nearest.assign(count, 0);
    std::vector<std::vector<double>> reach(execution.threads); // largest squares; their maximum is order-independent
    constexpr std::size_t grain = 1024;
    parallel_for(count, grain, execution, [&](std::size_t begin, std::size_t end, unsigned worker) {
        std::vector<double>& farthest = reach[worker];
        farthest.resize(n, 0.0);
        std::vector<BasisRow> rows(end - begin);
        basis.evaluate(std::span(vertices).subspan(begin, end - begin), rows);
        for (std::size_t v = begin; v < end; ++v) {
            const BasisRow& row = rows[v - begin];
            for (std::size_t k = 0; k < row.element.size(); ++k) {
                const double weight = row.weight[k];
                const Index i = row.element[k];
                if (weight == 0.0) {
                    continue;
                }
                result.sum[v] += weight;
                result.lebesgue[v] += std::abs(weight);
                ++result.overlap[v];
                farthest[i] =
                    std::max(farthest[i], (vertices[v].position - result.sites.points[i].position).squaredNorm());
                const auto shown = std::find(result.elements.begin(), result.elements.end(), i);
                if (shown != result.elements.end()) {
                    result.phi(static_cast<Eigen::Index>(v), shown - result.elements.begin()) = weight;
                }
            }
            result.nearest[v] = nearest.of(vertices[v]);
        }
    });
    result.reach.assign(n, 0.0);
    for (const std::vector<double>& farthest : reach) {
        for (std::size_t i = 0; i < farthest.size(); ++i) {
            result.reach[i] = std::max(result.reach[i], std::sqrt(farthest[i]));
        }
    }
}

void judge_elements(BasisInspection& result, const Basis& basis, const Execution& execution) {
    const std::size_t n = result.sites.size();
    result.at_own_site.assign(n, 0.0);
    parallel_for(n, 256, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow row;
        for (std::size_t i = begin; i < end; ++i) {
            basis.evaluate(result.sites.points[i], row);
            for (std::size_t k = 0; k < row.element.size(); ++k) {
                if (row.element[k] == i) {
                    result.at_own_site[i] = row.weight[k];
                }
            }
        }
    });
    result.sites.area = element_integrals(result.mesh, basis, result.sites.spacing, execution);

    result.sums_to_one = basis.sums_to_one();
    double area = 0.0;
    for (const auto& triangle : result.output.triangles) {
        const std::vector<SurfacePoint>& v = result.output.vertices;
        const Vec3 a = v[triangle[0]].position;
        const double third = (v[triangle[1]].position - a).cross(v[triangle[2]].position - a).norm() / 6.0;
        for (const Index corner : triangle) {
            if (!result.counts(corner)) {
                result.left_out += third;
                continue;
            }
            area += third;
            result.mean_overlap += third * result.overlap[corner];
            result.mean_lebesgue += third * result.lebesgue[corner];
        }
    }
    result.mean_overlap /= area;
    result.mean_lebesgue /= area;
    result.left_out /= area + result.left_out;
}

} // namespace

BasisInspection inspect_basis(const Registry& registry, const std::filesystem::path& file,
                              const InspectOptions& options, const Execution& execution) {
    check_options(options);
    BasisInspection result;
    result.options = options;
    result.file = file.string();
    const auto make = [&]<class T>(std::shared_ptr<T>& tool, const std::string& choice) {
        tool = registry.create<T>(choice);
        result.plugins.emplace_back(kind_of<T>(), registry.describe(kind_of<T>(), choice));
    };
    std::shared_ptr<Sampler> sampler;
    std::shared_ptr<Basis> basis;
    std::shared_ptr<Visibility> visibility;
    make(basis, options.basis);
    result.options.sampler = fitting_sampler(options.sampler, options.basis, *basis);
    make(sampler, result.options.sampler);
    if (sampler->needs_visibility()) {
        std::vector<std::string> notes;
        result.options.visibility = choose_visibility(registry, options.visibility, notes);
        make(visibility, result.options.visibility);
        for (const std::string& note : notes) {
            if (execution.progress != nullptr) {
                execution.progress->remark(note);
            }
        }
    }

    execution.phase("read");
    DiagnosedMesh diagnosed = diagnose(read_apart_from(result.options.outputs, registry, file), execution);
    result.diagnosis = std::move(diagnosed.diagnosis);
    result.mesh = std::move(diagnosed.mesh);
    if (execution.progress != nullptr) {
        for (const Finding& finding : result.diagnosis.findings) {
            if (finding.repaired) {
                execution.progress->remark(finding.message());
            }
        }
    }
    execution.phase("place sites");
    if (visibility) {
        visibility->build(result.mesh);
    }
    place_sites(result, *sampler, visibility.get(), execution);
    const NearestSites nearest(result.mesh, result.sites);
    result.elements = choose_elements(result, nearest);
    execution.phase("set up basis");
    basis->bind(result.mesh, result.sites, execution);

    execution.phase("refine output");
    if (result.options.output_spacing == 0.0) {
        result.options.output_spacing = output_in_spacings * result.options.spacing;
    }
    result.output =
        refine(result.mesh, result.options.output_spacing, execution.memory_left() / output_bytes, execution);
    execution.phase("evaluate");
    evaluate_vertices(result, *basis, nearest, execution);
    execution.phase("integrate elements");
    judge_elements(result, *basis, execution);
    return result;
}

} // namespace difusa
