// The reader `gltf`: lights and camera.
#include <readers.h>

#include <cmath>

#include "gltf_text.h"

namespace difusa::gltf_lights_test {
namespace {

using readers::notes;
using testing::AllOf;
using testing::HasSubstr;
using namespace gltf_text;

TEST(GltfReader, PunctualLights) {
    const std::string half = std::to_string(std::sqrt(0.5));
    const PolygonSoup soup = gltf(
        "\"extensionsRequired\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{"
        "\"type\":"
        "\"directional\",\"intensity\":683,\"color\":[1,0.5,0]},{\"type\":\"point\",\"intensity\":1366,\"name\":"
        "\"bulb\",\"range\":"
        "5},{\"type\":\"spot\",\"spot\":{\"innerConeAngle\":0.5,\"outerConeAngle\":1}}]}},\"nodes\":[{\"extensions\":{"
        "\"KHR_lights_punctual\":{\"light\":0}},\"rotation\":[" +
        half + ",0,0," + half +
        "]},{\"translation\":[1,2,3],\"scale\":[2,2,2],\"children\":[2],\"extensions\":{\"KHR_lights_punctual\":{"
        "\"light\":1}}},"
        "{\"translation\":[1,0,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}}]");
    ASSERT_EQ(soup.lights.suns.size(), 1U);
    // Turned by 90 degrees about x, what shone along -z shines along y: the sun is in the direction of -y.
    EXPECT_LT((soup.lights.suns[0].towards - Vec3(0, -1, 0)).norm(), 1e-6);
    EXPECT_TRUE((soup.lights.suns[0].irradiance == Rgb(1, 0.5, 0)).all());
    ASSERT_EQ(soup.lights.points.size(), 2U);
    const PointLight &bulb = soup.lights.points[0], &spot = soup.lights.points[1];
    EXPECT_EQ(bulb.name, "bulb");
    EXPECT_EQ(bulb.position, Vec3(1, 2, 3));
    EXPECT_TRUE((bulb.intensity == 2.0).all());
    EXPECT_FALSE(bulb.is_spot());
    EXPECT_EQ(spot.position, Vec3(3, 2, 3));
    EXPECT_EQ(spot.direction, Vec3(0, 0, -1));
    EXPECT_EQ(spot.cos_inner, std::cos(0.5));
    EXPECT_EQ(spot.cos_outer, std::cos(1.0));
    EXPECT_THAT(notes(soup), HasSubstr("lights with a range: 1"));
}

TEST(GltfReader, LightsDoNotCareForScale) {
    const auto lights = [](const std::string& parent, const std::string& node, const std::string& type) {
        return "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"" + type +
               "\"}]}},\"nodes\":[{\"children\":[1]," + parent + "},{" + node +
               ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]";
    };
    const std::string half = std::to_string(std::sqrt(0.5)), move = "\"translation\":[1,2,3]";
    const std::string about_x = "\"rotation\":[" + half + ",0,0," + half + "]";
    const std::string about_y = "\"rotation\":[0," + half + ",0," + half + "]";
    const std::string zero = "\"scale\":[0,0,0]", no_matrix = "\"matrix\":[0,0,0,0, 0,0,0,0, 0,0,0,0, 1,2,3,1]";
    EXPECT_EQ(gltf(lights(move + "," + zero, zero, "point")).lights.points.at(0).position, Vec3(1, 2, 3));
    EXPECT_EQ(gltf(lights(zero, no_matrix, "point")).lights.points.at(0).position, Vec3(0, 0, 0));
    // About x by 90 degrees, what shone along -z shines along y; about y then, along y still, or -z along -x.
    EXPECT_LT(
        (gltf(lights(about_y + "," + zero, about_x, "spot")).lights.points.at(0).direction - Vec3(0, 1, 0)).norm(),
        1e-6);
    EXPECT_LT((gltf(lights(about_y, zero, "directional")).lights.suns.at(0).towards - Vec3(1, 0, 0)).norm(), 1e-6);
    // A matrix that loses z alone still has a normal; of a matrix of zeros nothing is left.
    const std::string flat = "\"matrix\":[0,3,0,0, 0,0,2,0, 0,0,0,0, 0,0,0,1]";
    EXPECT_LT((gltf(lights(move, flat, "spot")).lights.points.at(0).direction - Vec3(-1, 0, 0)).norm(), 1e-15);
    EXPECT_THAT(refused(lights(move, no_matrix, "spot")), HasSubstr("is undefined"));
    EXPECT_THAT(refused(lights(no_matrix, about_x, "directional")), HasSubstr("is undefined"));
    const std::string projective = "\"matrix\":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,2]";
    EXPECT_THAT(refused(lights(move, projective, "spot")), HasSubstr("its last row must be 0 0 0 1"));
}

TEST(GltfReader, TheFirstPerspectiveCamera) {
    const PolygonSoup soup =
        gltf("\"cameras\":[{\"type\":\"orthographic\",\"orthographic\":{}},{\"type\":\"perspective\",\"perspective\":{"
             "\"yfov\":"
             "0.75,\"znear\":0.1}}],\"nodes\":[{\"camera\":0},{\"camera\":1,\"translation\":[1,2,3]},{\"camera\":1}]");
    ASSERT_TRUE(soup.camera);
    EXPECT_EQ(soup.camera->eye, Vec3(1, 2, 3));
    EXPECT_EQ(soup.camera->towards, Vec3(0, 0, -1));
    EXPECT_EQ(soup.camera->up, Vec3(0, 1, 0));
    EXPECT_EQ(soup.camera->view_angle, 0.75);
    EXPECT_THAT(notes(soup), AllOf(HasSubstr("cameras without perspective: 1"), HasSubstr("additional cameras: 1")));
}

} // namespace
} // namespace difusa::gltf_lights_test
