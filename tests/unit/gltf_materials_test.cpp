// The reader `gltf`: materials, textures and vertex colours.
#include <readers.h>

#include <cmath>
#include <numbers>

#include "gltf_text.h"

namespace difusa::gltf_materials_test {
namespace {

using readers::notes;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using namespace gltf_text;

TEST(GltfReader, ColoursOfVerticesAreFactors) {
    Arrays arrays = square();
    arrays.add<std::uint8_t>("VEC4", 5121, 4, {255, 0, 51, 255, 255, 255, 255, 0, 0, 0, 0, 0, 255, 255, 255, 255},
                             ",\"normalized\":true");
    const std::string mesh =
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":3},\"indices\":2,"
        "\"material\":0},{\"attributes\":{\"POSITION\":0},\"indices\":2,\"material\":0},{"
        "\"attributes\":{\"POSITION\":0},\"indices\":2},{\"attributes\":{\"POSITION\":0,\"COLOR_0\":3},"
        "\"indices\":2}]}],";
    const PolygonSoup soup =
        gltf("\"nodes\":[{\"mesh\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.5,0.5,1],"
             "\"metallicFactor\":0.5}}]," +
             mesh + arrays.embedded());
    ASSERT_EQ(soup.point_reflectance.size(), 16U);
    EXPECT_TRUE((soup.point_reflectance[0] == Rgb(0.25, 0, 0.25 * 0.2)).all());
    EXPECT_TRUE((soup.point_reflectance[12] == Rgb(1, 0, 0.2)).all());
    EXPECT_TRUE(soup.painted(0));
    EXPECT_FALSE(soup.painted(2));
    EXPECT_EQ(soup.face_material[4], none);
    EXPECT_FALSE(soup.painted(4));
    EXPECT_TRUE(soup.painted(6));
    // Of what the metal half reflects in a lobe, the mean over the corners 0, 1, 2, 0, 2, 3 of the primitive.
    const Material &painted = soup.materials[soup.face_material[0]], &plain = soup.materials[soup.face_material[2]];
    ASSERT_TRUE(painted.gloss && plain.gloss);
    EXPECT_TRUE((plain.gloss->reflectance == 0.25).all());
    const Rgb mean(4.0 / 6.0, 2.0 / 6.0, (2 * 0.2 + 2.0) / 6.0);
    EXPECT_LE((painted.gloss->reflectance - 0.25 * mean).abs().maxCoeff(), 1e-15);
    EXPECT_THAT(notes(soup), HasSubstr("primitives of metal with vertex colours"));
}

TEST(GltfReader, MetalOfOneVertexColourHasIt) {
    Arrays arrays = square();
    arrays.add<std::uint8_t>("VEC4", 5121, 4, {255, 0, 51, 255, 255, 0, 51, 255, 255, 0, 51, 255, 255, 0, 51, 255},
                             ",\"normalized\":true");
    for (const std::string roughness : {"0", "0.5"}) {
        const PolygonSoup soup =
            gltf("\"nodes\":[{\"mesh\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":1,"
                 "\"roughnessFactor\":" +
                 roughness +
                 "}}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":3},\"indices\":2,"
                 "\"material\":0}]}]," +
                 arrays.embedded());
        EXPECT_TRUE((soup.materials[soup.face_material[0]].specular() == Rgb(1.0, 0.0, 0.2)).all());
        EXPECT_THAT(notes(soup), Not(HasSubstr("vertex colours")));
    }
}

TEST(GltfReader, MaterialsAndLight) {
    const PolygonSoup soup = gltf(
        "\"nodes\":[{\"mesh\":0}],\"materials\":[{\"name\":\"lamp\",\"emissiveFactor\":[1,0.5,0],\"doubleSided\":true,"
        "\"alphaMode\":\"BLEND\",\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":683}},"
        "\"pbrMetallicRoughness\":{\"metallicFactor\":0.25}}]," +
        square_mesh + "," + square().embedded());
    const Material& lamp = soup.materials[0];
    EXPECT_TRUE(lamp.double_sided);
    EXPECT_TRUE((lamp.reflectance == 0.75).all());
    // A Lambertian surface of luminance 683 cd/m² sends pi 683 lm/m², which count as pi W/m².
    EXPECT_NEAR(lamp.emission[0], std::numbers::pi, 1e-14);
    EXPECT_NEAR(lamp.emission[1], 0.5 * std::numbers::pi, 1e-14);
    EXPECT_THAT(notes(soup), HasSubstr("materials that are not opaque: 1"));
    EXPECT_THAT(notes(gltf("\"nodes\":[{\"mesh\":0}],\"materials\":[{}]," + square_mesh + "," + square().embedded())),
                AllOf(HasSubstr("materials without \"metallicFactor\": 1 (\"material 0\"); glTF then implies metal"),
                      HasSubstr("reflects glossily and not diffusely; for paint export \"metallicFactor\": 0")));
}

TEST(GltfReader, NotesNameMaterialsAndMeshesOnce) {
    const std::string material = "{\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"normalTexture\":{\"index\":0},"
                                 "\"extensions\":{\"KHR_materials_madeup\":{},\"KHR_materials_ior\":{}}";
    Arrays arrays = square();
    arrays.add<std::uint16_t>("SCALAR", 5123, 4, {0, 1, 2, 0});
    std::string materials, primitives;
    for (int m = 0; m < 7; ++m) {
        const std::string comma = m == 0 ? "" : ",";
        materials += comma + material + (m == 3 ? ",\"occlusionTexture\":{\"index\":0}}" : "}");
        primitives += comma + "{\"attributes\":{\"POSITION\":0},\"indices\":" + (m == 2 ? "3" : "2") +
                      ",\"material\":" + std::to_string(m) + "}";
    }
    const PolygonSoup soup = gltf("\"nodes\":[{\"mesh\":0},{\"mesh\":0}],\"materials\":[" + materials +
                                  "],\"meshes\":[{\"primitives\":[" + primitives + "]}]," + arrays.embedded());
    EXPECT_EQ(soup.face_count(), 2U * 13);
    const std::string first = " (\"material 0\", \"material 1\", \"material 2\", \"material 3\", \"material 4\", ...)";
    EXPECT_THAT(
        soup.notes,
        testing::UnorderedElementsAre(
            "materials with normal textures: 7" + first + "; they are ignored: the shape is that of the triangles",
            "materials with occlusion textures: 1 (\"material 3\"); they are ignored: occlusion is computed",
            "materials with KHR_materials_madeup: 7" + first + "; it is ignored, the rest of them is used",
            "leftover vertices that form no triangle: 1 (mesh 0); they are ignored; export the mesh again"));
}

/// A picture of 2 by 2 pixels as BMP (told by its bytes): upper row 0 and 1, lower row 1 and 1, in all channels, where
/// 1 is `bright` of 255.
std::string picture(char bright = '\xff') {
    std::string bmp("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\2\0\0\0\2\0\0\0\1\0\x18\0", 30);
    return bmp + std::string(24, '\0') + std::string(6, bright) + std::string(2, '\0') + std::string(3, '\0') +
           std::string(3, bright) + std::string(2, '\0');
}

TEST(GltfReader, TexturesAndTheirPlacement) {
    const auto members = [](const std::string& info, const std::string& sampler) {
        return "\"nodes\":[{\"mesh\":0}],\"images\":[{\"uri\":\"data:image/png;base64," + base64(picture()) +
               "\"}],\"samplers\":[{" + sampler +
               "}],\"textures\":[{\"source\":0,\"sampler\":0}],\"materials\":[{\"pbrMetallicRoughness\":{"
               "\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0" +
               info + "}},\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0" + info + "}}]," + square_mesh +
               "," + square().embedded();
    };
    const auto read = [&](const std::string& info, const std::string& sampler) { return gltf(members(info, sampler)); };
    const PolygonSoup plain = read("", "");
    const Material& material = plain.materials[0];
    ASSERT_TRUE(material.reflectance_texture);
    EXPECT_EQ(material.reflectance_texture, material.emission_texture);
    // The only dark pixel is the upper left one.
    EXPECT_EQ(material.reflectance_texture->at({0.25, 0.75})[0], 0.0);
    EXPECT_EQ(material.reflectance_texture->at({0.75, 0.75})[0], 1.0);
    EXPECT_EQ(material.reflectance_texture->at({-0.75, 1.75})[0], 0.0) << "repeated";
    const PolygonSoup clamped = read("", "\"wrapS\":33071,\"wrapT\":33648");
    EXPECT_EQ(clamped.materials[0].reflectance_texture->at({-5, 0.75})[0], 0.0);
    EXPECT_EQ(clamped.materials[0].reflectance_texture->at({0.25, 1.25})[0], 0.0) << "mirrored";
    EXPECT_THAT(refused(members("", "\"wrapS\":3.3e45")), HasSubstr("\"wrapS\" must be a non-negative whole number"));
    EXPECT_THAT(refused(members("", "\"wrapT\":1")), HasSubstr("\"wrapT\" must be 10497 (repeat), 33071 (clamp)"));
    // Scaled to half, then turned by 90 degrees counterclockwise on the picture, whose v runs downwards (u' = v/2,
    // v' = -u/2), then moved by (0, 1): (u, v) = (0.5, 0.5) shows (0.25, 0.75), which is 0.25 from below.
    const PolygonSoup turned = read(",\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0,1],\"rotation\":"
                                    "1.5707963267948966,\"scale\":[0.5,0.5]}}",
                                    "");
    const Texture& texture = *turned.materials[0].reflectance_texture;
    for (const auto& [u, v] : {std::pair{0.5, 0.5}, std::pair{1.5, 0.5}, std::pair{0.5, 1.5}, std::pair{1.25, 1.0}}) {
        const TextureCoordinates shown(0.5 * v, 1.0 - (1.0 - 0.5 * u));
        EXPECT_NEAR(texture.at({u, 1.0 - v})[0], material.reflectance_texture->at(shown)[0], 1e-12) << u << " " << v;
    }
}

TEST(GltfReader, PicturesThatAreMissingOrDamaged) {
    const auto with = [](const std::string& image) {
        return "\"nodes\":[{\"mesh\":0}],\"images\":[" + image +
               "],\"textures\":[{\"source\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0,"
               "\"baseColorTexture\":{\"index\":0}}}]," +
               square_mesh + "," + square().embedded();
    };
    EXPECT_THAT(notes(gltf(with("{\"uri\":\"gone.png\"}"))), HasSubstr("missing texture images: 1"));
    EXPECT_THAT(refused(with("{\"bufferView\":0}")), HasSubstr("test.gltf, image 0: "));
    EXPECT_THAT(refused(with("{\"uri\":\"data:image/png;base64,?\"}")), HasSubstr("base64"));
    EXPECT_THAT(refused(with("{\"uri\":\"https://a.b/c.png\"}")), HasSubstr("download"));
    EXPECT_THAT(refused(with("{}")), HasSubstr("needs \"uri\""));
}

TEST(GltfReader, MetalOfATextureIsItsMean) {
    const PolygonSoup soup = gltf(
        "\"nodes\":[{\"mesh\":0}],\"images\":[{\"uri\":\"data:image/bmp;base64," + base64(picture()) +
        "\"}],\"textures\":[{\"source\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"metallicRoughnessTexture\":{"
        "\"index\":0}}}]," +
        square_mesh + "," + square().embedded());
    EXPECT_TRUE((soup.materials[0].reflectance == 0.25).all());
    EXPECT_THAT(notes(soup), HasSubstr("metalness has a texture: 1"));
}

TEST(GltfReader, PolishedMetalsAreMirrors) {
    const auto material = [](const std::string& pbr) {
        const PolygonSoup soup = gltf("\"nodes\":[{\"mesh\":0}],\"materials\":[{\"pbrMetallicRoughness\":{" + pbr +
                                      "}}]," + square_mesh + "," + square().embedded());
        return std::pair(soup.materials[0], notes(soup));
    };
    const std::string colour = "\"baseColorFactor\":[0.5,0.25,1,1],";
    const auto [mirror, quiet] = material(colour + "\"metallicFactor\":1,\"roughnessFactor\":0");
    EXPECT_TRUE((mirror.mirror == Rgb(0.5, 0.25, 1.0)).all());
    EXPECT_TRUE((mirror.reflectance == 0.0).all());
    EXPECT_EQ(quiet, "");
    const auto [half, also_quiet] = material(colour + "\"metallicFactor\":0.5,\"roughnessFactor\":0");
    EXPECT_TRUE((half.mirror == Rgb(0.25, 0.125, 0.5)).all());
    EXPECT_TRUE((half.reflectance == half.mirror).all());
    const auto [paint, no_note] = material(colour + "\"metallicFactor\":0,\"roughnessFactor\":0");
    EXPECT_TRUE((paint.mirror == 0.0).all());
    EXPECT_FALSE(paint.gloss);
}

TEST(GltfReader, RoughMetalsAreGlossy) {
    const auto material = [](const std::string& pbr, const std::string& more = "") {
        const PolygonSoup soup = gltf("\"nodes\":[{\"mesh\":0}],\"materials\":[{\"pbrMetallicRoughness\":{" + pbr +
                                      "}}]," + more + square_mesh + "," + square().embedded());
        return std::pair(soup.materials[0], notes(soup));
    };
    const std::string colour = "\"baseColorFactor\":[0.5,0.25,1,1],";
    const auto [rough, quiet] = material(colour + "\"metallicFactor\":0.5,\"roughnessFactor\":0.4");
    EXPECT_TRUE((rough.mirror == 0.0).all());
    ASSERT_TRUE(rough.gloss);
    EXPECT_TRUE((rough.gloss->reflectance == Rgb(0.25, 0.125, 0.5)).all());
    EXPECT_TRUE((rough.reflectance == rough.gloss->reflectance).all());
    EXPECT_EQ(rough.gloss->shape, (LobeShape{LobeShape::Model::ggx, 0.4}));
    EXPECT_EQ(quiet, "");
    const auto [fine, also_quiet] = material(colour + "\"metallicFactor\":1,\"roughnessFactor\":0.001");
    ASSERT_TRUE(fine.gloss);
    EXPECT_EQ(fine.gloss->shape.sharpness, LobeShape::least_roughness);
    const auto [implied, noted] = material("\"baseColorFactor\":[0.5,0.25,1,1]");
    ASSERT_TRUE(implied.gloss);
    EXPECT_EQ(implied.gloss->shape.sharpness, 1.0);
    EXPECT_THAT(noted, HasSubstr("materials without \"metallicFactor\""));
}

/// Both colours of KHR_materials_pbrSpecularGlossiness, and that they take the place of the others.
TEST(GltfReader, SpecularGlossiness) {
    const auto material = [](const std::string& gloss, const std::string& name, bool required) {
        return gltf((required ? "\"extensionsRequired\":[\"" + name + "\"]," : std::string()) +
                    "\"nodes\":[{\"mesh\":0}],\"images\":[{\"uri\":\"data:image/bmp;base64," + base64(picture()) +
                    "\"},{\"uri\":\"data:image/bmp;base64," + base64(picture('\x80')) +
                    "\"}],\"textures\":[{\"source\":0},{\"source\":1}],\"materials\":[{\"pbrMetallicRoughness\":{"
                    "\"baseColorFactor\":[0.1,0.2,0.3,1]},\"extensions\":{\"" +
                    name + "\":{" + gloss + "}}}]," + square_mesh + "," + square().embedded());
    };
    const std::string extension = "KHR_materials_pbrSpecularGlossiness";
    for (const bool required : {false, true}) {
        const PolygonSoup soup = material("\"diffuseFactor\":[0.5,0.25,1,0.5],\"specularFactor\":[0.25,0.5,0],"
                                          "\"diffuseTexture\":{\"index\":1}",
                                          extension, required);
        EXPECT_TRUE((soup.materials[0].reflectance == Rgb(0.25, 0.125, 0.5)).all());
        ASSERT_TRUE(soup.materials[0].reflectance_texture);
        // 128 of 255 in sRGB: ((128/255 + 0.055) / 1.055)^2.4.
        EXPECT_NEAR(soup.materials[0].reflectance_texture->at({0.25, 0.25})[0],
                    std::pow((128.0 / 255.0 + 0.055) / 1.055, 2.4), 1e-6);
        EXPECT_THAT(soup.notes, IsEmpty());
    }
    const PolygonSoup mirror = material("", extension, false);
    EXPECT_TRUE((mirror.materials[0].reflectance == 0.0).all()) << "both colours are white by default";
    EXPECT_THAT(notes(mirror), HasSubstr("metallic materials: 1 (\"material 0\")"));
    // Three of four pixels are white: 1/4 of what is diffuse is left, with half the specular colour 5/8.
    const PolygonSoup painted =
        material("\"specularFactor\":[0.5,0,0.5],\"specularGlossinessTexture\":{\"index\":0}", extension, false);
    EXPECT_TRUE((painted.materials[0].reflectance == 0.625).all());
    EXPECT_THAT(notes(painted), HasSubstr("specular colour has a texture: 1"));
    EXPECT_THAT(refused(scene("{\"mesh\":0}")
                            .replace(scene("{\"mesh\":0}").find("\"pbrMetallicRoughness\""), 0,
                                     "\"extensions\":{\"" + extension + "\":{\"diffuseFactor\":[1,1,1]}},")),
                HasSubstr("\"diffuseFactor\""));
    // Unlit materials are paint, though they do not say that they are no metal.
    const PolygonSoup unlit = material("", "KHR_materials_unlit", true);
    EXPECT_TRUE((unlit.materials[0].reflectance == Rgb(0.1, 0.2, 0.3)).all());
    EXPECT_THAT(unlit.notes, ElementsAre(HasSubstr("unlit materials: 1 (\"material 0\")")));
}

} // namespace
} // namespace difusa::gltf_materials_test
