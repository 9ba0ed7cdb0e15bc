// Geometry and light are apart: everything that the linear system knows of the surface has the same bits whatever the
// surface reflects and emits and whatever shines on it, and one system serves all lights.
#include <difusa/algebra/hit_lists.h>
#include <difusa/bake.h>
#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/scene/light_groups.h>

#include <support/lightings.h>
#include <support/lit_scenes.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace difusa::separation_test {
namespace {

using namespace lit;
using test::lightings;

BakeOptions options_for(const std::string& transport, const std::string& basis = "normalized-radial") {
    BakeOptions options = quick(0.3, 32);
    options.transport = transport;
    options.basis = basis;
    options.every_surface = true;
    return options;
}

Values random_values(std::size_t rows, Eigen::Index columns, const char* name) {
    RandomStream random(17, name);
    Values values(static_cast<Eigen::Index>(rows), columns);
    for (double& value : values.reshaped()) {
        value = random.uniform() - 0.25;
    }
    return values;
}

Values applied(const LinearOperator& A) {
    Values y;
    A.apply(random_values(A.columns(), 3, "operand"), y, Execution{});
    return y;
}

Values applied_transposed(const LinearOperator& A) {
    Values y;
    A.apply_transpose(random_values(A.rows(), 2, "transposed operand"), y, Execution{});
    return y;
}

void expect_same_sites(const SiteSet& a, const SiteSet& b) {
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(a.radius, b.radius);
    EXPECT_EQ(a.area, b.area);
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(a.points[i].position, b.points[i].position);
        EXPECT_EQ(a.points[i].face, b.points[i].face);
    }
}

/// Bit for bit.
void expect_same_system(const RadiositySystem& a, const RadiositySystem& b) {
    const Discretisation &d = a.discretisation(), &e = b.discretisation();
    expect_same_sites(*d.sites, *e.sites);
    EXPECT_EQ(d.integrals, e.integrals);
    ASSERT_EQ(d.surfels->size(), e.surfels->size());
    for (Index s = 0; s < d.surfels->size(); ++s) {
        EXPECT_EQ(d.surfels->area(s), e.surfels->area(s));
    }
    EXPECT_EQ(applied(*d.averages), applied(*e.averages));
    ASSERT_EQ(d.points.size(), e.points.size());
    const Values values = random_values(d.points.size(), 3, "values");
    EXPECT_EQ(d.projection->coefficients(values), e.projection->coefficients(values));
    EXPECT_EQ(d.evaluation->coefficients(values), e.evaluation->coefficients(values));
    EXPECT_EQ(a.transport().sky, b.transport().sky);
    EXPECT_EQ(a.transport().back, b.transport().back);
    const LinearOperator &V = *a.transport().W, &W = *b.transport().W;
    ASSERT_EQ(V.columns(), W.columns());
    EXPECT_EQ(applied(V), applied(W));
    EXPECT_EQ(applied_transposed(V), applied_transposed(W));
    const auto* const p = dynamic_cast<const HitLists*>(&V);
    const auto* const q = dynamic_cast<const HitLists*>(&W);
    ASSERT_EQ(p == nullptr, q == nullptr);
    if (p != nullptr) {
        std::vector<Index> bins, others;
        for (std::size_t j = 0; j < p->rows(); ++j) {
            p->row(j, bins);
            q->row(j, others);
            ASSERT_EQ(bins, others) << "row " << j;
        }
    } else {
        Values unit = Values::Zero(static_cast<Eigen::Index>(V.columns()), 1), v, w;
        for (Eigen::Index c = 0; c < unit.rows(); c += 7) {
            unit.setZero();
            unit(c, 0) = 1.0;
            V.apply(unit, v, Execution{});
            W.apply(unit, w, Execution{});
            ASSERT_EQ(v, w) << "column " << c;
        }
    }
}

void expect_same_light(const Solution& a, const Solution& b, const std::string& name) {
    EXPECT_EQ(a.h, b.h) << name;
    EXPECT_EQ(a.direct, b.direct) << name;
    EXPECT_EQ(a.irradiance, b.irradiance) << name;
    EXPECT_EQ(a.solve.residual_history, b.solve.residual_history) << name;
    EXPECT_EQ(a.spectral_radius, b.spectral_radius) << name;
    EXPECT_EQ(a.area_lights, b.area_lights) << name;
    EXPECT_TRUE((a.energy.absorbed == b.energy.absorbed).all()) << name;
    EXPECT_EQ(a.field->parts().smooth, b.field->parts().smooth) << name;
    EXPECT_EQ(a.field->parts().soft_direct, b.field->parts().soft_direct) << name;
}

TEST(Separation, TheOperatorKnowsNothingOfLight) {
    for (const char* transport : {"gather", "pairwise"}) {
        for (const char* basis : {"normalized-radial", "moving-least-squares"}) {
            const BakeOptions options = options_for(transport, basis);
            std::shared_ptr<const RadiositySystem> first;
            for (const auto& [name, scene] : lightings()) {
                SCOPED_TRACE(name + ", " + transport + ", " + basis);
                const BakeResult result = baked(scene, options);
                if (first) {
                    expect_same_system(*first, *result.system);
                } else {
                    first = result.system;
                }
            }
        }
    }
}

TEST(Separation, TheScenesDifferInTheirAreaLights) {
    std::vector<std::size_t> lights;
    for (const auto& [name, scene] : lightings()) {
        lights.push_back(baked(scene, options_for("gather")).solution.area_lights);
    }
    EXPECT_EQ(lights[0], 0U);
    EXPECT_EQ(lights[1], 2U);
    EXPECT_EQ(lights[4], 0U) << "what emits unevenly is left to the rays";
}

/// The system of each scene, solved for each other.
TEST(Separation, OneSystemServesAllLights) {
    for (const char* transport : {"gather", "pairwise"}) {
        for (const bool groups : {false, true}) {
            BakeOptions options = options_for(transport);
            options.light_groups = groups;
            const auto scenes = lightings();
            const BakeResult first = baked(scenes.front().second, options);
            for (const auto& [name, scene] : scenes) {
                const BakeResult fresh = baked(scene, options);
                LightingOptions how{groups ? light_groups(*fresh.scene) : all_lights(*fresh.scene)};
                how.solve = fresh.options.solve;
                const Solution relit = first.system->solve(fresh.scene, how, Execution{2, nullptr, nullptr});
                expect_same_light(relit, fresh.solution, name + ", " + transport);
                // And what a user sees of it.
                std::vector<SurfacePoint> x;
                for (Index t = 0; t < fresh.scene->mesh.triangles.size(); ++t) {
                    x.push_back(fresh.scene->mesh.at(t, 0.3, 0.4));
                }
                for (const std::size_t gather : {0, 16}) {
                    const PointValues a = relit.field->at(x, gather, 3, "there", Execution{}),
                                      b = fresh.field().at(x, gather, 3, "there", Execution{});
                    EXPECT_EQ(a.B, b.B) << name;
                    EXPECT_EQ(a.H_direct, b.H_direct) << name;
                    ASSERT_EQ(a.groups.size(), b.groups.size());
                    for (std::size_t g = 0; g < a.groups.size(); ++g) {
                        EXPECT_EQ(a.groups[g].name, b.groups[g].name);
                        EXPECT_EQ(a.groups[g].B, b.groups[g].B) << name;
                    }
                }
            }
        }
    }
}

/// Lights alone differ: one matrix of right-hand sides.
TEST(Separation, ManyLightsTogetherAreLikeEachAlone) {
    for (const char* transport : {"gather", "pairwise"}) {
        const BakeResult first = baked(lightings().front().second, options_for(transport));
        std::vector<std::shared_ptr<const Scene>> scenes;
        for (int i = 0; i < 5; ++i) {
            Scene scene = *first.scene;
            scene.sky = i == 0 ? Rgb::Zero() : Rgb(1, 2, 3); // the first is dark
            if (i > 1) {
                scene.suns = {{Vec3(0.1 * i, -1, 2).normalized(), Rgb(7, 5, 1)}};
            }
            if (i > 3) {
                scene.materials[2].emission = Rgb(5, 9, 2);
                scene.point_lights = {{Vec3(1.5, 0.5, 1.0), Rgb::Constant(2)}};
            }
            scenes.push_back(std::make_shared<Scene>(std::move(scene)));
        }
        const std::vector<Solution> together = first.system->solve(scenes, {}, Execution{2, nullptr, nullptr});
        ASSERT_EQ(together.size(), scenes.size());
        EXPECT_EQ(together[0].irradiance.cwiseAbs().maxCoeff(), 0.0);
        for (std::size_t i = 1; i < scenes.size(); ++i) {
            expect_same_light(together[i], first.system->solve(scenes[i], {}, Execution{}), std::to_string(i));
        }
        EXPECT_THROW(first.system->solve(scenes[0], {}, Execution{}), InputError);
        auto other = std::make_shared<Scene>(*scenes[1]);
        other->materials[0].reflectance = Rgb(0.1, 0.2, 0.3);
        scenes.push_back(other);
        EXPECT_THROW(first.system->solve(scenes, {}, Execution{}), UsageError);
    }
}

/// An engine that counts what it is asked.
class CountingVisibility final : public Visibility {
  public:
    explicit CountingVisibility(std::shared_ptr<const Visibility> engine) : engine_(std::move(engine)) {}
    void build(const Mesh& /*mesh*/) override {}
    void first_hits(std::span<const Ray> rays, std::span<Hit> hits) const override {
        first_hits_cast += rays.size();
        engine_->first_hits(rays, hits);
    }
    void occluded(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const override {
        segments_cast += segments.size();
        engine_->occluded(segments, blocked);
    }
    mutable std::atomic<std::size_t> first_hits_cast = 0, segments_cast = 0;

  private:
    std::shared_ptr<const Visibility> engine_;
};

TEST(Separation, LightingASystemCastsNoFirstHitRay) {
    const auto scenes = lightings();
    const BakeResult first = baked(scenes.front().second, options_for("gather"));
    SystemParts parts = first.system->parts();
    const auto counting = std::make_shared<CountingVisibility>(parts.engine);
    parts.engine = counting;
    const auto system = std::make_shared<RadiositySystem>(parts);
    std::size_t shadow_rays = 0;
    for (const auto& [name, scene] : scenes) {
        const auto shared = std::make_shared<Scene>(scene);
        for (const bool in_basis : {false, true}) {
            LightingOptions how{light_groups(*shared)};
            how.direct_in_basis = in_basis;
            Journal journal;
            counting->segments_cast = 0;
            const Solution solution = system->solve(shared, how, Execution{1, nullptr, &journal});
            EXPECT_EQ(counting->first_hits_cast, 0U) << name;
            EXPECT_EQ(counting->segments_cast, journal.count_of("segments")) << name;
            EXPECT_EQ(journal.count_of("rays"), 0U) << name;
            shadow_rays += counting->segments_cast;
        }
    }
    EXPECT_GT(shadow_rays, 0U);
}

TEST(Separation, AnotherSurfaceIsRefused) {
    const BakeResult result = baked(lightings().front().second, options_for("gather"));
    auto other = std::make_shared<Scene>(*result.scene);
    other->mesh.points[0] += Vec3(0.0, 0.0, 0.25);
    other->mesh.derive();
    EXPECT_THROW(result.system->solve(other, {all_lights(*other)}, Execution{}), UsageError);
}

TEST(Separation, ImpossibleLightsAndMaterialsAreRefused) {
    const BakeResult result = baked(lightings().front().second, options_for("gather"));
    const auto refused = [&](const char* why, const auto& change) {
        auto scene = std::make_shared<Scene>(*result.scene);
        scene->suns = {{Vec3::UnitZ(), Rgb::Ones()}};
        change(*scene);
        EXPECT_THAT([&] { result.system->solve(scene, {}, Execution{}); },
                    testing::ThrowsMessage<InputError>(testing::HasSubstr(why)));
    };
    refused("non-unit length", [](Scene& scene) { scene.suns[0].towards *= 3.0; });
    refused("a sun has", [](Scene& scene) { scene.suns[0].irradiance = Rgb::Constant(-5.0); });
    refused("the sky's irradiance",
            [](Scene& scene) { scene.sky = Rgb::Constant(std::numeric_limits<double>::quiet_NaN()); });
    refused("material number 0 has a reflectance outside [0,1]", [](Scene& scene) {
        scene.materials[0].name.clear();
        scene.materials[0].reflectance = Rgb::Constant(1.5);
    });
}

/// Whatever the basis: the message must not blame it.
TEST(Separation, AClosedSceneThatAbsorbsNothingIsTheReason) {
    BakeOptions options = options_for("gather");
    options.basis = "moving-least-squares";
    const BakeResult result = baked(test::uniform_scene(test::box(1.0, 1, true), 0.5, 1.0), options);
    auto scene = std::make_shared<Scene>(*result.scene);
    scene->materials[0].reflectance = Rgb::Ones();
    EXPECT_THAT([&] { result.system->solve(scene, {}, Execution{}); },
                testing::ThrowsMessage<BouncesDoNotDieOut>(testing::HasSubstr("absorbs nothing")));
}

TEST(Separation, AllLightsAreTheDefaultAndOthersAreRefused) {
    const auto scenes = lightings();
    const BakeResult first = baked(scenes.front().second, options_for("gather"));
    for (const auto& [name, scene] : scenes) {
        const auto shared = std::make_shared<Scene>(scene);
        EXPECT_EQ(first.system->solve(shared, {}, Execution{}).irradiance,
                  first.system->solve(shared, {all_lights(*shared)}, Execution{}).irradiance)
            << name;
        LightingOptions others{all_lights(*shared)};
        others.sets.sun.push_back(0);
        EXPECT_THROW(first.system->solve(shared, others, Execution{}), UsageError) << name;
    }
}

/// A block beside a closed room, which is lit inside: the block sees nothing but the backs of the room's walls.
TEST(Separation, LightOnSurfacesWithoutSitesIsRefused) {
    const Mesh room = test::box(1.0, 1, true);
    Scene scene = test::uniform_scene(test::together(room, test::moved(test::box(1.0), 1.0, Vec3(3, 0, 0))), 0.5, 0.0);
    scene.point_lights = {{Vec3(0.5, 0.5, 0.5), Rgb::Ones()}};
    for (const bool every_surface : {false, true}) {
        BakeOptions options = options_for("gather");
        options.every_surface = every_surface;
        const BakeResult result = baked(scene, options);
        const auto brighter = std::make_shared<Scene>(scene), other = std::make_shared<Scene>(scene),
                   sky = std::make_shared<Scene>(scene);
        brighter->point_lights[0].intensity = Rgb::Constant(2.0);
        other->point_lights[0].position += Vec3(3, 0, 2);
        sky->sky = Rgb::Ones();
        EXPECT_EQ(result.system->solve(brighter, {}, Execution{}).irradiance, Values(2.0 * result.solution.irradiance));
        if (every_surface) {
            EXPECT_GT(result.system->solve(other, {}, Execution{}).irradiance.maxCoeff(), 0.0);
        } else {
            EXPECT_THROW(result.system->solve(other, {}, Execution{}), UsageError);
            EXPECT_THROW(result.system->solve(sky, {}, Execution{}), UsageError);
        }
    }
}

} // namespace
} // namespace difusa::separation_test
