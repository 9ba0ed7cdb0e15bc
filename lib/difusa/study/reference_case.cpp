#include <difusa/study/reference_case.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/import/shapes.h>
#include <difusa/plugin/parameters.h>
#include <difusa/study/references/ball_over_disc.h>
#include <difusa/study/references/bowl.h>
#include <difusa/study/references/cylinder.h>
#include <difusa/study/references/manufactured.h>
#include <difusa/study/references/plates.h>
#include <difusa/study/references/shelf.h>
#include <difusa/study/references/sphere.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>

namespace difusa {

namespace {

Material grey(const std::string& name, double rho, double E = 0.0) {
    Material material;
    material.name = name;
    material.reflectance = Rgb::Constant(rho);
    material.emission = Rgb::Constant(E);
    return material;
}

ReferenceCase ball_over_disc() {
    const BallOverDiscParameters p;
    ReferenceCase result;
    Mesh ball = sphere(p.r, 6, Front::outside);
    move(ball, Vec3(0, 0, p.h));
    Scene& scene = result.scene;
    add(scene.mesh, ball, 0);
    add(scene.mesh, disc(p.R, 64), 1);
    scene.materials = {grey("ball", p.beta), grey("disc", p.delta)};
    scene.suns = {{Vec3::UnitZ(), Rgb::Constant(p.mu)}};
    const Vec3 centre(0, 0, p.h);
    const Mesh& mesh = scene.mesh;
    const std::vector<Index> material = mesh.material;
    result.normal = [centre, material](const SurfacePoint& x) {
        return material[x.face] == 0 ? Vec3((x.position - centre).normalized()) : Vec3(Vec3::UnitZ());
    };
    result.exact = std::make_shared<BallOverDisc>(p);
    result.mesh_error = 2e-4; // facets lie up to (edge/radius)²/6 = 5e-5 inside the ball, its outline likewise
    result.spacings = {6.0, 3.0, 1.5, 1.0, 0.75};
    return result;
}

/// A function on the unit square, interpolated at Chebyshev nodes with the barycentric formula in both directions.
class ChebyshevTable {
  public:
    ChebyshevTable(std::size_t n, const std::function<double(double, double)>& f) {
        DIFUSA_REQUIRE(n <= most);
        for (std::size_t k = 0; k < n; ++k) {
            const double angle = std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(n);
            node_.push_back(0.5 - 0.5 * std::cos(angle));
            weight_.push_back((k % 2 == 0 ? 1.0 : -1.0) * std::sin(angle));
        }
        for (const double v : node_) {
            for (const double u : node_) {
                value_.push_back(f(u, v));
            }
        }
    }

    double operator()(double u, double v) const {
        std::array<double, most> at_u{}, at_v{};
        const std::span<const double> shares = weights(u, at_u);
        double value = 0.0;
        for (std::size_t j = 0; const double share : weights(v, at_v)) {
            value += share * std::inner_product(shares.begin(), shares.end(), &value_[j++ * node_.size()], 0.0);
        }
        return value;
    }

  private:
    static constexpr std::size_t most = 64; ///< nodes

    /// Of the values at the nodes, for the interpolant at x; they sum to 1.
    std::span<const double> weights(double x, std::array<double, most>& room) const {
        const std::span<double> w(room.data(), node_.size());
        double total = 0.0;
        for (std::size_t k = 0; k < w.size(); ++k) {
            if (x == node_[k]) {
                std::fill(w.begin(), w.end(), 0.0);
                w[k] = 1.0;
                return w;
            }
            total += w[k] = weight_[k] / (x - node_[k]);
        }
        for (double& share : w) {
            share /= total;
        }
        return w;
    }
    std::vector<double> node_, weight_, value_;
};

ReferenceCase manufactured_box() {
    const Vec3 size(1.0, 1.2, 0.9);
    const double rho = 0.5;
    ReferenceCase result;
    const auto exact = std::make_shared<ManufacturedBox>(size, rho, ManufacturedBox::waves(size, 1.0, 0.3, 1.0));
    result.exact = exact;
    result.scene.mesh = box(Vec3::Zero(), size, 8, Front::inside);
    const char* const names[] = {"x low", "x high", "y low", "y high", "z low", "z high"};
    for (Eigen::Index face = 0; face < 6; ++face) {
        const Eigen::Index axis = face / 2, first = (axis + 1) % 3, second = (axis + 2) % 3;
        const bool far = face % 2 == 1;
        const Vec3 n = (far ? -1.0 : 1.0) * Vec3::Unit(axis);
        const auto place = [=](double u, double v) {
            Vec3 x;
            x[axis] = far ? size[axis] : 0.0;
            x[first] = u * size[first];
            x[second] = v * size[second];
            return x;
        };
        const auto table =
            std::make_shared<ChebyshevTable>(32, [&](double u, double v) { return exact->at(place(u, v), n).E; });
        Material material = grey(names[face], rho, 1.0);
        material.emission_pattern = [=](const Vec3& x) {
            return (*table)(x[first] / size[first], x[second] / size[second]);
        };
        result.scene.materials.push_back(std::move(material));
    }
    result.mesh_error = 1e-5; // the emission is interpolated from 32 x 32 values per face
    result.spacings = {0.24, 0.12, 0.06, 0.03};
    result.smooth = true;
    return result;
}

ReferenceCase inside_of_sphere() {
    ReferenceCase result;
    result.exact = std::make_shared<InsideOfSphere>(
        0.5, [](const Vec3& w) { return 1.0 + w.z(); }, 1.0);
    result.scene.mesh = sphere(1.0, 5, Front::inside);
    Material material = grey("wall", 0.5, 1.0);
    material.emission_pattern = [](const Vec3& x) { return 1.0 + x.normalized().z(); };
    result.scene.materials = {material};
    result.normal = [](const SurfacePoint& x) { return Vec3(-x.position.normalized()); };
    result.mesh_error = 1e-3; // facets deviate by up to 0.02 from the sphere's tangents
    result.spacings = {0.4, 0.2, 0.1, 0.05};
    result.smooth = true;
    return result;
}

ReferenceCase bowl() {
    BowlParameters p;
    p.half_angle = 1.2;
    p.rho = 0.8;
    p.towards_sun = Vec3(std::cos(0.5), 0.0, std::sin(0.5));
    p.sun = 1000.0;
    ReferenceCase result;
    result.exact = std::make_shared<Bowl>(p);
    result.scene.mesh = spherical_cap(1.0, p.half_angle, 64, Front::inside);
    result.scene.materials = {grey("wall", p.rho)};
    result.scene.suns = {{p.towards_sun, Rgb::Constant(p.sun)}};
    result.normal = [](const SurfacePoint& x) { return Vec3(-x.position.normalized()); };
    result.mesh_error = 2e-2; // the shadow's edge moves with the facets
    result.spacings = {0.2, 0.1, 0.05, 0.025};
    return result;
}

ReferenceCase plates() {
    PlatesParameters p;
    p.rho1 = 0.5;
    p.rho2 = 0.8;
    const double side = 40.0;
    const auto exact = std::make_shared<Plates>(p);
    ReferenceCase result;
    result.exact = exact;
    Scene& scene = result.scene;
    scene.mesh = rectangle(Vec3(-20, -20, 0), Vec3(side, 0, 0), Vec3(0, side, 0), 8, 8);
    add(scene.mesh, rectangle(Vec3(-20, -20, p.gap), Vec3(0, side, 0), Vec3(side, 0, 0), 8, 8), 1);
    scene.materials = {grey("lower", p.rho1, p.E1), grey("upper", p.rho2, p.E2)};
    result.judged = [](const Vec3& x) { return std::abs(x.x()) < 1.0 && std::abs(x.y()) < 1.0; };
    // The middle's bound also covers its surroundings, for plates shortened by twice their distance from it.
    const double shorter = side - 2.0;
    result.mesh_error = std::max(exact->missing_in_the_middle(1, shorter).most / exact->at({}, Vec3::UnitZ()).B(),
                                 exact->missing_in_the_middle(2, shorter).most / exact->at({}, -Vec3::UnitZ()).B());
    result.spacings = {2.0, 1.0};
    return result;
}

ReferenceCase infinite_shelf() {
    return shelf_of_length(24.0);
}

ReferenceCase inside_of_cylinder() {
    const CylinderParameters p;
    const double length = 12.0;
    const auto exact = std::make_shared<InsideOfCylinder>(p);
    ReferenceCase result;
    result.exact = exact;
    result.scene.mesh = cylinder(p.radius, length, 256, 48, Front::inside);
    Material material = grey("wall", p.rho, 1.0);
    material.emission_pattern = [](const Vec3& x) { return 1.0 + x.x() / std::hypot(x.x(), x.y()); };
    result.scene.materials = {material};
    result.normal = [](const SurfacePoint& x) { return Vec3(-Vec3(x.position.x(), x.position.y(), 0.0).normalized()); };
    result.judged = [](const Vec3& x) { return std::abs(x.z()) < 1.0; };
    // As for the plates; facets deviate by up to pi/256 from the tangents.
    const double least_B = p.constant / (1.0 - p.rho) - p.amplitude / (1.0 + p.rho / 3.0);
    result.mesh_error = exact->missing_in_the_middle(length - 2.0).most / least_B + std::numbers::pi / 256;
    result.spacings = {0.6, 0.3, 0.15};
    result.smooth = true;
    return result;
}

struct Entry {
    ReferenceCaseName name;
    ReferenceCase (*make)();
};

const std::vector<Entry>& cases() {
    static const std::vector<Entry> all{
        {{"ball-over-disc", "a ball of radius 5 at height 20 over a disc of radius 40, under a sun at the zenith, "
                            "reflectance 0.9 (T chapter 7)"},
         ball_over_disc},
        {{"manufactured-box", "a closed box with B = 1 + 0.3 cos(pi x/a) cos(pi y/b) cos(pi z/c), reflectance 0.5, and "
                              "the emission to match"},
         manufactured_box},
        {{"sphere", "the inside of a sphere, E = 1 + z, reflectance 0.5: the same irradiance everywhere"},
         inside_of_sphere},
        {{"bowl", "a spherical bowl of half-angle 1.2 under a sun 0.5 rad above the horizon, reflectance 0.8: partly "
                  "shaded"},
         bowl},
        {{"plates", "parallel plates of side 40 at a distance of 1, the lower one emitting, compared in the middle 2 "
                    "by 2"},
         plates},
        {{"shelf", "a shelf of depth and height 1 and length 24 (L 33), its floor and back emitting, reflectance 0.5, "
                   "compared in the middle 2"},
         infinite_shelf},
        {{"cylinder", "the inside of a cylinder of length 12 and radius 1, E = 1 + cos(theta), compared in the middle "
                      "sixth"},
         inside_of_cylinder}};
    return all;
}

} // namespace

std::vector<ReferenceCaseName> reference_cases() {
    std::vector<ReferenceCaseName> names;
    for (const Entry& entry : cases()) {
        names.push_back(entry.name);
    }
    return names;
}

std::vector<std::string> reference_case_names() {
    std::vector<std::string> names;
    for (const Entry& entry : cases()) {
        names.emplace_back(entry.name.name);
    }
    return names;
}

void require_reference_case(const std::string& name) {
    const std::vector<std::string> known = reference_case_names();
    if (std::find(known.begin(), known.end(), name) != known.end()) {
        return;
    }
    const std::string near = nearest_name(name, known);
    std::string all;
    for (const std::string& other : known) {
        all += (all.empty() ? "" : ", ") + other;
    }
    throw UsageError("--case " + name + ": unknown case" + (near.empty() ? "" : ", did you mean " + near + "?") +
                     " (known: " + all + ")");
}

ReferenceCase shelf_of_length(double length) {
    ShelfParameters p;
    p.E = {1.0, 0.5, 0.0};
    const double middle = std::min(1.0, 0.125 * length);
    const auto parts = static_cast<int>(std::max(1L, std::lround(length)));
    const auto exact = std::make_shared<Shelf>(p);
    ReferenceCase result;
    result.exact = exact;
    Scene& scene = result.scene;
    const double low = -0.5 * length;
    scene.mesh = rectangle(Vec3(0, low, 0), Vec3(p.a, 0, 0), Vec3(0, length, 0), 1, parts);
    add(scene.mesh, rectangle(Vec3(0, low, 0), Vec3(0, length, 0), Vec3(0, 0, p.b), parts, 1), 1);
    add(scene.mesh, rectangle(Vec3(0, low, p.b), Vec3(0, length, 0), Vec3(p.a, 0, 0), parts, 1), 2);
    scene.materials = {grey("floor", p.rho[0], p.E[0]), grey("back", p.rho[1], p.E[1]),
                       grey("ceiling", p.rho[2], p.E[2])};
    result.judged = [=](const Vec3& x) { return std::abs(x.y()) < middle; };
    // The least radiosity is the ceiling's, in front; half of its mean is less.
    result.mesh_error = exact->missing(0.5 * length - middle) / (0.5 * exact->mean_radiosity()[2]);
    result.spacings = {0.4, 0.2, 0.1};
    return result;
}

ReferenceCase edge_case(double rho) {
    ShelfParameters p;
    p.E = {1.0, 1.0, 0.0};
    p.rho = {rho, rho, 0.0}; // a black ceiling is as good as none
    ReferenceCase result;
    result.name = "edge";
    result.exact = std::make_shared<Shelf>(p);
    Scene& scene = result.scene;
    const Vec3 along(0, 0.5, 0);
    scene.mesh = rectangle(Vec3::Zero(), Vec3(p.a, 0, 0), along);
    add(scene.mesh, rectangle(Vec3::Zero(), along, Vec3(0, 0, p.b)), 0);
    scene.mesh.repetition.planes = {{Vec3::Zero(), Vec3::UnitY()}, {along, -Vec3::UnitY()}};
    scene.materials = {grey("wall", rho, p.E[0])};
    return result;
}

ReferenceCase reference_case(const std::string& name) {
    require_reference_case(name);
    const auto found =
        std::find_if(cases().begin(), cases().end(), [&](const Entry& entry) { return entry.name.name == name; });
    ReferenceCase result = found->make();
    result.name = name;
    return result;
}

} // namespace difusa
