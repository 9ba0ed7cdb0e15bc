// Thermal materials and surroundings in scene files.
#include <scene_file_fixture.h>

#include <gtest/gtest.h>

#include <string>

namespace difusa::scene_file_thermal_test {
namespace {

using Given = Thermal::Given;

class ThermalSceneFile : public test::SceneFile {
  protected:
    PolygonSoup material(const std::string& members) const {
        return read("{\"difusa_scene\": 1,\n\"meshes\": [{\"file\": \"square.off\", \"material\": \"m\"}],\n"
                    "\"materials\": {\"m\":\n{" +
                    members + "}}}");
    }
    void expect_refused(const std::string& members, const std::string& text) const {
        const std::string message = refusal([&] { material(members); });
        EXPECT_NE(message.find("scene.json:4: "), std::string::npos) << message;
        EXPECT_NE(message.find(text), std::string::npos) << message;
    }
};

TEST_F(ThermalSceneFile, SaysWhatIsKnownOfASurface) {
    const auto expect = [&](const std::string& members, Given given, double value, double emissivity) {
        const Material read = material(members).materials[0];
        ASSERT_TRUE(read.thermal.has_value()) << members;
        EXPECT_EQ(read.thermal->given, given) << members;
        EXPECT_DOUBLE_EQ(read.thermal->value, value) << members;
        EXPECT_DOUBLE_EQ(read.thermal->emissivity, emissivity) << members;
    };
    expect(R"("emissivity": 0.8, "temperature": 300)", Given::temperature, 300.0, 0.8);
    expect(R"("emissivity": 1, "temperature": 0)", Given::temperature, 0.0, 1.0);
    expect(R"("emissivity": 0, "celsius": 20)", Given::temperature, 293.15, 0.0);
    expect(R"("emissivity": 0.3, "net_flux": -50)", Given::net_flux, -50.0, 0.3);
    expect(R"("emissivity": 0.3, "heat": 12.5, "double_sided": true)", Given::heat, 12.5, 0.3);
    expect(R"("adiabatic": true)", Given::net_flux, 0.0, 1.0);
    expect(R"("emissivity": 0, "adiabatic": true)", Given::net_flux, 0.0, 0.0);
    expect(R"("net_flux": 0)", Given::net_flux, 0.0, 1.0);
    expect(R"("emissivity": 0.1, "mirror": 0.9, "temperature": 80)", Given::temperature, 80.0, 0.1);
    expect(R"("mirror": 0.9, "adiabatic": true)", Given::net_flux, 0.0, 0.1);
    EXPECT_FALSE(material(R"("mirror": 1)").materials[0].thermal.has_value());
}

TEST_F(ThermalSceneFile, RefusesContradictions) {
    expect_refused(R"("emissivity": 0.8)", "needs one of");
    expect_refused(R"("temperature": 300)", "needs an \"emissivity\"");
    expect_refused(R"("heat": 300)", "needs an \"emissivity\"");
    expect_refused(R"("emissivity": 0.8, "temperature": 300, "net_flux": 0)", "has only one of");
    expect_refused(R"("emissivity": 0.8, "temperature": 300, "celsius": 20)", "has only one of");
    expect_refused(R"("adiabatic": false)", "is true or left out");
    expect_refused(R"("adiabatic": 1)", "\"adiabatic\" must be");
    expect_refused(R"("emissivity": 0.8, "temperature": -1)", "\"temperature\" is -1: it must be from 0 to 1e6 K");
    expect_refused(R"("emissivity": 0.8, "celsius": -274)", "\"celsius\" is -274: it must be from -273.15");
    expect_refused(R"("emissivity": 1.2, "temperature": 300)", "must be from 0 (reflects everything) to 1 (black)");
    expect_refused(R"("emissivity": 0.2, "mirror": 0.9, "temperature": 300)", "add up to more than 1");
    expect_refused(R"("emissivity": 0, "net_flux": 5)", "can neither give away nor take in heat");
    expect_refused(R"("emissivity": 0.5, "net_flux": 1e31)", "must be from -1e30 to 1e30");
    expect_refused(R"("emissivity": 0.5, "temperature": 300, "reflectance": 0.5)",
                   "\"reflectance\": a thermal material");
    expect_refused(R"("emissivity": 0.5, "temperature": 300, "emission": 5)", "\"emission\": a thermal material");
    expect_refused(R"("emissivity": 0.5, "temperature": 300, "light_group": "a")", "\"light_group\": a thermal");
    expect_refused(R"("emisivity": 0.5)", "did you mean");
}

/// A thermal scene whose faces have other materials would be baked as one that is lit.
TEST_F(ThermalSceneFile, RefusesMaterialsThatNoFaceHas) {
    const std::string unused =
        refused_with(R"("materials": {"m": {"emissivity": 0.8, "temperature": 300}, "n": {"adiabatic": true}})");
    EXPECT_NE(refusal([&] {
                  read(R"({"difusa_scene": 1, "materials": {"m": {"adiabatic": true}, "plain": {}},
                           "meshes": [{"file": "square.off", "material": "plain"}]})");
              }).find("no face has any of the materials with a temp"),
              std::string::npos);
    EXPECT_NE(unused.find("scene.json:3: no face has any of the materials with a temp"), std::string::npos) << unused;
}

TEST_F(ThermalSceneFile, HasSurroundings) {
    EXPECT_FALSE(with("\"up\": \"z\"").surroundings.has_value());
    EXPECT_EQ(with(R"("surroundings": {"temperature": 2.7})").surroundings, 2.7);
    EXPECT_DOUBLE_EQ(*with(R"("surroundings": {"celsius": -10})").surroundings, 263.15);
    EXPECT_NE(refused_with(R"("surroundings": {})").find("needs either"), std::string::npos);
    EXPECT_NE(refused_with(R"("surroundings": {"temperature": 1, "celsius": 1})").find("has both"), std::string::npos);
    EXPECT_NE(refused_with(R"("surroundings": {"temperature": -1})").find("from 0 to 1e6 K"), std::string::npos);
    EXPECT_NE(refused_with(R"("surroundings": 300)").find("\"surroundings\" must be"), std::string::npos);
}

} // namespace
} // namespace difusa::scene_file_thermal_test
