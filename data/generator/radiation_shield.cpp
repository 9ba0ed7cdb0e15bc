#include "scenes.h"

namespace scenes {

Scene radiation_shield() {
    Scene scene;
    Surface& shaft = scene.surface;
    shaft.remarks = {
        "Two plates 0.2 m apart, a thin sheet half way between them, and mirrors around, which make all three "
        "infinite.",
        "Made up for this project by data/generator/radiation_shield.cpp.",
        "Exact answer: the sheet, polished on both sides, cuts the heat between the plates from 1609.40 to 75.39 "
        "W/m^2.",
    };
    const double height = 0.2;
    const unsigned hot = shaft.add({"hot", {}, {}, {}, R"("emissivity": 0.8, "temperature": 500)"});
    const unsigned cold = shaft.add({"cold", {}, {}, {}, R"("emissivity": 0.6, "temperature": 300)"});
    const unsigned shield = shaft.add({"shield", {}, {}, {}, R"("emissivity": 0.05, "heat": 0, "double_sided": true)"});
    const unsigned mirror = shaft.add({"mirror", {}, {}, {}, R"("mirror": 1)"});
    const std::array<unsigned, 6> around{mirror, mirror, mirror, mirror, hot, cold};
    add_box(shaft, {0, 0, 0}, {1, 1, height}, {1, 1, 2}, around, true); // the sheet ends on edges of the mirrors
    const double middle = 0.5 * height;
    shaft.polygon({{0, 0, middle}, {1, 0, middle}, {1, 1, middle}, {0, 1, middle}}, shield);
    scene.camera = {{2.6, -2.2, 1.1}, {0.5, 0.5, 0.1}, 30.0};
    return scene;
}

} // namespace scenes
