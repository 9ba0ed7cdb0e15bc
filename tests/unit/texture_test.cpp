// Textures: where they are looked up, and that a bake with them is that of the colours they show.
#include <difusa/bake.h>
#include <difusa/repair/texture_coordinates.h>
#include <difusa/scene/texture.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "soups.h"

#include <limits>
#include <memory>

namespace difusa::texture_test {
namespace {

using test::make_soup;
using testing::HasSubstr;

/// Upper row: 0.1 0.2; lower row: 0.3 0.4.
Image four() {
    Image image{2, 2, {}};
    for (const float value : {0.1F, 0.2F, 0.3F, 0.4F}) {
        image.pixels.push_back({value, value, value});
    }
    return image;
}

double value(const Texture& texture, double u, double v) {
    return texture.at({u, v})[0];
}

TEST(Texture, TheOriginIsTheLowerLeftCorner) {
    const Texture texture(four());
    EXPECT_EQ(value(texture, 0.25, 0.25), 0.3F);
    EXPECT_EQ(value(texture, 0.75, 0.25), 0.4F);
    EXPECT_EQ(value(texture, 0.25, 0.75), 0.1F);
    EXPECT_EQ(value(texture, 0.75, 0.75), 0.2F);
    EXPECT_NEAR(value(texture, 0.5, 0.5), 0.25, 1e-7);
    EXPECT_NEAR(texture.mean()[0], 0.25, 1e-7);
}

TEST(Texture, BeyondTheEdges) {
    const Texture clamped(four(), Texture::Wrap::clamp, Texture::Wrap::clamp);
    EXPECT_EQ(value(clamped, -3.0, 0.25), 0.3F);
    EXPECT_EQ(value(clamped, 3.0, 7.0), 0.2F);
    const Texture repeated(four());
    EXPECT_EQ(value(repeated, -0.75, 5.25), 0.3F);
    const Texture mirrored(four(), Texture::Wrap::mirror, Texture::Wrap::repeat);
    EXPECT_EQ(value(mirrored, 1.25, 0.25), 0.4F);
    EXPECT_EQ(value(mirrored, -0.25, 0.25), 0.3F);
}

TEST(Texture, APlacementMovesItsCoordinates) {
    TexturePlacement place;
    place << 0, 2, 0.25, -1, 0, 1; // u' = 2 v + 0.25, v' = 1 - u
    const Texture plain(four()),
        moved(std::make_shared<const Image>(four()), Texture::Wrap::repeat, Texture::Wrap::repeat, place);
    for (const double u : {0.0, 0.125, 0.75}) {
        for (const double v : {0.0, 0.25, 0.5}) {
            EXPECT_EQ(value(moved, u, v), value(plain, 2 * v + 0.25, 1 - u));
        }
    }
}

TEST(SettleTextures, TheMeanColourIsAFactorOnVertexColours) {
    PolygonSoup soup = make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {2, 1, 0}});
    soup.point_reflectance = {Rgb::Constant(0.5), Rgb::Constant(0.25), Rgb::Ones()};
    soup.colours_by_material = true;
    soup.materials.resize(1);
    soup.materials[0].vertex_colours = true;
    soup.materials[0].reflectance_texture = std::make_shared<const Texture>(four());
    soup.face_material = {0, 0};
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    for (const bool all : {true, false}) {
        PolygonSoup settled = soup;
        if (!all) { // the second face has coordinates
            settled.corner_texture.assign(3, {unknown, unknown});
            settled.corner_texture.insert(settled.corner_texture.end(), {{0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}});
        }
        settle_textures(settled);
        ASSERT_EQ(settled.notes.size(), 1U);
        ASSERT_EQ(settled.corner_texture.size(), 6U);
        const Material& mean = settled.materials[settled.face_material[0]];
        ASSERT_TRUE(mean.reflectance_texture);
        EXPECT_TRUE(is_placed_on(mean, settled.corner_texture[0]));
        EXPECT_NEAR(mean.reflectance_texture->at(settled.corner_texture[0])[0], 0.25, 1e-7);
        EXPECT_EQ(settled.face_material[1], all ? settled.face_material[0] : 0U);
        EXPECT_TRUE(settled.painted(0));
    }
}

TEST(SettleTextures, FacesWhoseTextureIsPlacedTooFarAwayHaveTheMeanColour) {
    for (const double scale : {1e9, 1e12, 1e308, std::numeric_limits<double>::infinity()}) {
        for (const bool emission : {false, true}) {
            TexturePlacement place;
            place << scale, 0, 0, 0, 1, 0;
            const auto texture = std::make_shared<const Texture>(std::make_shared<const Image>(four()),
                                                                 Texture::Wrap::repeat, Texture::Wrap::clamp, place);
            PolygonSoup soup = make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
            soup.corner_texture = {{0.0, 0.0}, {1.0, 0.0}, {-1.0, 1.0}};
            soup.materials.resize(1);
            soup.materials[0].name = "far";
            (emission ? soup.materials[0].emission_texture : soup.materials[0].reflectance_texture) = texture;
            soup.materials[0].emission = soup.materials[0].reflectance = Rgb::Ones();
            soup.face_material.assign(1, 0);
            settle_textures(soup);
            if (scale == 1e9) {
                EXPECT_EQ(soup.face_material[0], 0U);
                EXPECT_TRUE(soup.notes.empty());
                continue;
            }
            ASSERT_EQ(soup.face_material[0], 1U) << scale;
            const Material& plain = soup.materials[1];
            EXPECT_FALSE(is_textured(plain));
            EXPECT_NEAR((emission ? plain.emission : plain.reflectance)[0], 0.25, 1e-7);
            ASSERT_EQ(soup.notes.size(), 1U);
            EXPECT_THAT(soup.notes[0],
                        HasSubstr("too far to resolve pixels: 1 (first: face 0 (line 100), of \"far\")"));
        }
    }
}

TEST(SettleTextures, FacesWithoutCoordinatesHaveTheMeanColour) {
    PolygonSoup soup = make_soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}});
    Material material{"picture", Rgb::Constant(0.5), Rgb::Constant(8.0)};
    material.reflectance_texture = std::make_shared<const Texture>(four());
    material.emission_texture = material.reflectance_texture;
    soup.materials = {material};
    soup.face_material = {0, 0, none};
    soup.corner_texture.assign(9, TextureCoordinates(0.5, 0.5));
    settle_textures(soup);
    EXPECT_EQ(soup.materials.size(), 1U);
    EXPECT_TRUE(soup.notes.empty());
    soup.corner_texture[4][1] = std::numeric_limits<double>::infinity();
    settle_textures(soup);
    ASSERT_EQ(soup.materials.size(), 2U);
    EXPECT_THAT(soup.face_material, testing::ElementsAre(0, 1, none));
    EXPECT_EQ(soup.materials[1].name, "picture");
    EXPECT_FALSE(is_textured(soup.materials[1]));
    EXPECT_NEAR(soup.materials[1].reflectance[0], 0.125, 1e-7);
    EXPECT_NEAR(soup.materials[1].emission[0], 2.0, 1e-6);
    ASSERT_EQ(soup.notes.size(), 1U);
    EXPECT_THAT(soup.notes[0], HasSubstr("1 (first: face 1 (line 101))"));
}

} // namespace
} // namespace difusa::texture_test
