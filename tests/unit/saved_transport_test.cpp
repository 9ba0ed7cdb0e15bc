#include <difusa/algebra/hit_lists.h>
#include <difusa/bake/saved_transport.h>
#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/io/field_file.h>

#include <support/lightings.h>
#include <support/refusal.h>
#include <support/saved_bakes.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace difusa::saved_transport_test {
namespace {

using test::read_file;
using test::refusal_of;
using test::ScratchDirectory;
using testing::HasSubstr;

BakeResult small_bake(const std::string& transport = "gather", unsigned threads = 1) {
    BakeOptions options = test::relightable(transport, "normalized-radial");
    options.suns = {{Vec3(1, 2, 3).normalized(), Rgb(4, 5, 6), "afternoon"}};
    options.point_lights = {{Vec3(1, 1, 1), Rgb(7, 8, 9)}};
    options.sky = Rgb(1, 2, 3);
    options.seed = 0xfedcba9876543210U;
    return bake(test::registry(), test::bare_room(), "scene", options, Execution{threads, nullptr, nullptr});
}

void save(const SavedTransport& saved, const std::filesystem::path& file) {
    WholeFile whole(file);
    write_transport(saved, whole);
    whole.commit();
}

TEST(SavedTransport, ComesBackWithTheSameBits) {
    for (const char* transport : {"gather", "pairwise"}) {
        const SavedTransport a = saved_transport_of(small_bake(transport));
        const ScratchDirectory scratch;
        save(a, scratch / "file");
        const SavedTransport b = load_transport(scratch / "file", Execution{});
        EXPECT_EQ(b.scene, "scene");
        EXPECT_EQ(a.geometry, b.geometry);
        EXPECT_EQ(a.discretisation, b.discretisation);
        EXPECT_EQ(a.options.transport, b.options.transport);
        EXPECT_EQ(a.options.seed, b.options.seed);
        EXPECT_EQ(b.options.suns.at(0).name, "afternoon");
        EXPECT_EQ(b.options.suns.at(0).towards, a.options.suns.at(0).towards);
        EXPECT_TRUE((b.options.point_lights.at(0).intensity == Rgb(7, 8, 9)).all());
        EXPECT_TRUE((b.options.sky.value() == Rgb(1, 2, 3)).all());
        EXPECT_FALSE(b.options.reflectance);
        EXPECT_EQ(a.sites->radius, b.sites->radius);
        EXPECT_EQ(a.sites->area, b.sites->area);
        EXPECT_EQ(a.sites->region, b.sites->region);
        for (std::size_t i = 0; i < a.sites->size(); ++i) {
            EXPECT_EQ(a.sites->points[i].position, b.sites->points[i].position);
            EXPECT_EQ(a.sites->points[i].normal, b.sites->points[i].normal);
            EXPECT_EQ(a.sites->points[i].u, b.sites->points[i].u);
        }
        EXPECT_EQ(a.gathered.sky, b.gathered.sky);
        EXPECT_EQ(a.gathered.back, b.gathered.back);
        EXPECT_EQ(a.gathered.rays, b.gathered.rays);
        EXPECT_EQ(dynamic_cast<const HitLists&>(*a.gathered.W).packed().codes,
                  dynamic_cast<const HitLists&>(*b.gathered.W).packed().codes);
        ASSERT_EQ(a.form_factors == nullptr, b.form_factors == nullptr);
        if (a.form_factors) {
            EXPECT_EQ(a.form_factors->packed().value, b.form_factors->packed().value);
        }
        save(b, scratch / "again");
        EXPECT_EQ(read_file(scratch / "file"), read_file(scratch / "again"));
    }
}

TEST(SavedTransport, HasTheSameBytesForAnyNumberOfThreads) {
    const ScratchDirectory scratch;
    save_transport(small_bake("gather", 1), scratch / "one");
    save_transport(small_bake("gather", 3), scratch / "three");
    EXPECT_EQ(read_file(scratch / "one"), read_file(scratch / "three"));
}

TEST(SavedTransport, StatesItsSize) {
    const ScratchDirectory scratch;
    const SavedTransport saved = saved_transport_of(small_bake());
    save(saved, scratch / "file");
    const double bytes = saved.bytes_per_site() * static_cast<double>(saved.sites->size());
    const auto size = static_cast<double>(std::filesystem::file_size(scratch / "file"));
    EXPECT_LE(bytes, size);
    EXPECT_LE(size - bytes, 64000.0) << "what does not grow with the sites";
}

TEST(SavedTransport, RefusesAThousandCorruptions) {
    const ScratchDirectory scratch;
    save_transport(small_bake(), scratch / "file");
    const std::string good = read_file(scratch / "file");
    RandomStream random(8, "corruptions");
    for (int trial = 0; trial < 1000; ++trial) {
        std::string bad = good;
        switch (trial % 4) {
        case 0:
            bad.resize(random.below(good.size()));
            break;
        case 1: // one bit
            bad[random.below(good.size())] ^= static_cast<char>(1U << random.below(8));
            break;
        case 2: // one bit of the seal or of the beginning of the content
            bad[random.below(1024)] ^= static_cast<char>(1U << random.below(8));
            break;
        default: // a page of zeros, or of other bytes
            const std::size_t at = random.below(good.size()), length = 1 + random.below(4096);
            for (std::size_t i = at; i < std::min(good.size(), at + length); ++i) {
                bad[i] = trial % 8 < 4 ? '\0' : static_cast<char>(random.below(256));
            }
            if (bad == good) {
                bad.push_back('\0');
            }
        }
        write_whole_file(scratch / "bad", bad);
        EXPECT_THAT(refusal_of([&] { load_transport(scratch / "bad", Execution{}); }, "trial " + std::to_string(trial)),
                    HasSubstr("--save-transport"));
    }
}

/// Those of the scene are read from its file again; the ones among the options would be lost.
TEST(SavedTransport, HasNoPlaceForExtendedLightsOfTheOptions) {
    BakeResult result = small_bake();
    EXPECT_NO_THROW(saved_transport_of(result));
    BakeResult with_disc = result, with_opening = result;
    with_disc.requested.suns[0].disc = 0.005;
    EXPECT_THROW(saved_transport_of(with_disc), UsageError);
    with_opening.requested.point_lights[0].half_length = 0.1;
    EXPECT_THROW(saved_transport_of(with_opening), UsageError);
}

/// Files with a good seal, made by somebody else.
TEST(SavedTransport, RefusesUnsoundNumbers) {
    const SavedTransport good = saved_transport_of(small_bake("pairwise"));
    const ScratchDirectory scratch;
    const auto refused = [&](const std::string& what, const auto& damage) {
        SavedTransport bad = good;
        auto sites = std::make_shared<SiteSet>(*good.sites);
        damage(bad, *sites);
        bad.sites = sites;
        save(bad, scratch / "bad");
        EXPECT_THAT(refusal_of([&] { load_transport(scratch / "bad", Execution{}); }, what), HasSubstr(what));
    };
    refused("without a unit normal", [](SavedTransport&, SiteSet& sites) { sites.points[3].normal *= 2.0; });
    refused("outside of its triangle", [](SavedTransport&, SiteSet& sites) { sites.points[3].u = 1.5; });
    refused("not finite", [](SavedTransport&, SiteSet& sites) { sites.points[3].position.y() = NAN; });
    refused("too small a radius", [](SavedTransport&, SiteSet& sites) { sites.radius[0] = 0.0; });
    refused("no spacing", [](SavedTransport&, SiteSet& sites) { sites.spacing = 0.0; });
    refused("no spacing", [](SavedTransport& saved, SiteSet&) { saved.options.spacing = 0.0; });
    refused("/sites/face", [](SavedTransport&, SiteSet& sites) { sites.region.pop_back(); });
    refused("neighbours", [](SavedTransport&, SiteSet& sites) { sites.neighbours = 0; });
    refused("from 0 to 1", [](SavedTransport& saved, SiteSet&) { saved.gathered.sky[2] = -0.1; });
    refused("from 0 to 1", [](SavedTransport& saved, SiteSet&) { saved.gathered.back[2] = NAN; });
    refused("from 0 to 1", [](SavedTransport& saved, SiteSet&) { saved.contraction->radius = 1.0; });
    refused("from 0 to 1", [](SavedTransport& saved, SiteSet&) { saved.contraction->radius = -0.5; });
    refused("not a finite number", [](SavedTransport& saved, SiteSet&) { saved.contraction->radius = NAN; });
    refused("/transport/sky", [](SavedTransport& saved, SiteSet&) { saved.gathered.sky.pop_back(); });
    refused("as many rays", [](SavedTransport& saved, SiteSet&) { saved.gathered.rays *= 2; });
    refused("surfels", [](SavedTransport& saved, SiteSet&) { ++saved.gathered.surfels; });
    refused("is missing", [](SavedTransport& saved, SiteSet&) { saved.form_factors = nullptr; });
    refused("for each site", [](SavedTransport& saved, SiteSet&) {
        SparseRows::Packed packed = saved.form_factors->packed();
        ++packed.columns;
        saved.form_factors = std::make_shared<SparseRows>(packed);
    });
    refused("--rays", [](SavedTransport& saved, SiteSet&) { saved.options.rays = 0; });
    refused("max_iterations", [](SavedTransport& saved, SiteSet&) { saved.options.solve.max_iterations = -1; });
    refused("--sun", [](SavedTransport& saved, SiteSet&) { saved.options.suns[0].towards *= 2.0; });
    refused("--sky", [](SavedTransport& saved, SiteSet&) { saved.options.sky = Rgb(-1, 0, 0); });
}

TEST(SavedTransport, NeedsSitesEverywhere) {
    // A block beside a closed room, which is lit inside, has no sites.
    Scene scene = test::uniform_scene(
        test::together(test::box(1.0, 1, true), test::moved(test::box(1.0), 1.0, Vec3(3, 0, 0))), 0.5, 0.0);
    scene.point_lights = {{Vec3(0.5, 0.5, 0.5), Rgb::Ones()}};
    BakeOptions options = lit::quick(0.3, 32);
    EXPECT_THROW(saved_transport_of(lit::baked(scene, options)), UsageError);
    options.every_surface = true;
    EXPECT_NO_THROW(saved_transport_of(lit::baked(scene, options)));
}

} // namespace
} // namespace difusa::saved_transport_test
