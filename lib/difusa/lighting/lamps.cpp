#include <difusa/lighting/lamps.h>

#include <difusa/core/parallel.h>
#include <difusa/core/random.h>
#include <difusa/lighting/lambert.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace difusa {

namespace {

constexpr double largest_share = 0.1;
constexpr std::size_t most_triangles = 4096;
constexpr std::size_t most_materials = 32;

/// The lamps of one material at one site.
struct Group {
    Index material = none;
    std::vector<Index> triangles;
};

/// Fractional parts of i times the powers of the plastic number's inverse: an even sequence in the square (Roberts).
double even_u(std::size_t i) {
    return static_cast<double>(i) * 0.7548776662466927;
}
double even_v(std::size_t i) {
    return static_cast<double>(i) * 0.5698402909980532;
}
double fraction(double x) {
    return x - std::floor(x);
}

/// Serves one site after another.
class LampLight {
  public:
    LampLight(const Mesh& mesh, const Visibility& visibility, std::size_t samples)
        : mesh_(mesh), visibility_(visibility), samples_(samples) {}

    /// Light of the group's lamps of unit radiosity at x.
    double at(const SurfacePoint& x, const Group& group, RandomStream& stream) {
        form_factor_.clear();
        double F = 0.0;
        for (const Index t : group.triangles) {
            F += t == x.face ? 0.0
                             : lambert_form_factor(x.position, x.normal, mesh_.corner(t, 0), mesh_.corner(t, 1),
                                                   mesh_.corner(t, 2));
            form_factor_.push_back(F); // running sum
        }
        if (!(F > 0.0)) {
            return 0.0;
        }
        place_samples(x, group, F, stream);
        blocked_.resize(segments_.size());
        visibility_.occluded(segments_, blocked_);
        double seen = 0.0, all = 0.0;
        for (std::size_t s = 0; s < segments_.size(); ++s) {
            all += weight_[s];
            seen += blocked_[s] == 0 ? weight_[s] : 0.0;
        }
        cast_ += segments_.size();
        return all > 0.0 ? F * seen / all : F; // grazing: every sample fell below the horizon
    }

    std::size_t cast() const { return cast_; }

  private:
    /// Sample s goes to the lamp that holds the share (s + shift) / samples of the form factor, to an even place on it.
    void place_samples(const SurfacePoint& x, const Group& group, double F, RandomStream& stream) {
        segments_.clear();
        weight_.clear();
        const double shift = stream.uniform(), shift_u = stream.uniform(), shift_v = stream.uniform();
        for (std::size_t s = 0; s < samples_; ++s) {
            const double share = F * (static_cast<double>(s) + shift) / static_cast<double>(samples_);
            const auto place = std::upper_bound(form_factor_.begin(), form_factor_.end(), share);
            const std::size_t lamp =
                std::min(static_cast<std::size_t>(place - form_factor_.begin()), form_factor_.size() - 1);
            const double own = form_factor_[lamp] - (lamp == 0 ? 0.0 : form_factor_[lamp - 1]);
            if (!(own > 0.0)) {
                continue;
            }
            const double root = std::sqrt(fraction(even_u(s) + shift_u)), part = fraction(even_v(s) + shift_v);
            const SurfacePoint y = mesh_.at(group.triangles[lamp], root * (1.0 - part), root * part);
            const Vec3 way = y.position - x.position;
            const double cosines = x.normal.dot(way) * -y.normal.dot(way);
            const double r2 = way.squaredNorm();
            if (x.normal.dot(way) > 0.0 && cosines > 0.0) {
                segments_.push_back({x.position, y.position, x.face, y.face});
                weight_.push_back(cosines / (r2 * r2) * mesh_.areas[y.face] / own);
            }
        }
    }

    const Mesh& mesh_;
    const Visibility& visibility_;
    std::size_t samples_;
    std::size_t cast_ = 0;
    std::vector<double> form_factor_, weight_;
    std::vector<Segment> segments_;
    std::vector<std::uint8_t> blocked_;
};

} // namespace

std::vector<Index> lamp_triangles(const Scene& scene) {
    const std::vector<char> emits = emitting_materials(scene);
    std::vector<Index> lamps;
    std::set<Index> materials;
    double area = 0.0;
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        if (emits[scene.mesh.material[t]] != 0) {
            lamps.push_back(t);
            materials.insert(scene.mesh.material[t]);
            area += scene.mesh.areas[t];
        }
    }
    if (area > largest_share * scene.mesh.area || lamps.size() > most_triangles || materials.size() > most_materials) {
        lamps.clear();
    }
    return lamps;
}

void gather_lamps(const Scene& scene, const std::vector<Index>& lamps, const SiteSet& sites,
                  const Visibility& visibility, std::size_t samples, std::uint64_t seed, const Execution& execution,
                  Transport& transport) {
    std::map<Index, Group> groups;
    for (const Index t : lamps) {
        Group& group = groups[scene.mesh.material[t]];
        group.material = scene.mesh.material[t];
        group.triangles.push_back(t);
    }
    transport.L = SparseRows(sites.size(), scene.materials.size());
    std::vector<std::size_t> cast(execution.threads, 0);
    parallel_for(sites.size(), 16, execution, [&](std::size_t begin, std::size_t end, unsigned worker) {
        LampLight light(scene.mesh, visibility, samples);
        for (std::size_t j = begin; j < end; ++j) {
            RandomStream stream(seed, "lamps", j);
            SparseRows::Row& row = transport.L.row(j);
            for (const auto& [material, group] : groups) {
                const double value = light.at(sites.points[j], group, stream);
                if (value > 0.0) {
                    row.column.push_back(material);
                    row.value.push_back(value);
                }
            }
        }
        cast[worker] += light.cast();
    });
    for (const std::size_t count : cast) {
        transport.segments += count;
    }
}

} // namespace difusa
