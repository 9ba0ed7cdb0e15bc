#include "scenes.h"

namespace scenes {

Scene oven() {
    Scene scene;
    Surface& oven = scene.surface;
    oven.remarks = {
        "An oven, 2 m long, 1 m wide and high: a roof that gives off 20 kW, a slab to be heated on its floor, "
        "insulated",
        "walls, and a door that is cooled from outside. Made up for this project by data/generator/oven.cpp.",
    };
    const unsigned roof = oven.add({"roof", {}, {}, {}, R"("emissivity": 0.9, "heat": 20000)"});
    const unsigned wall = oven.add({"wall", {}, {}, {}, R"("adiabatic": true)"});
    const unsigned slab = oven.add({"slab", {}, {}, {}, R"("emissivity": 0.7, "celsius": 500)"});
    const unsigned door = oven.add({"door", {}, {}, {}, R"("emissivity": 0.4, "net_flux": -1500)"});
    add_box(oven, {0, 0, 0}, {2, 1, 1}, {1, 1, 1}, {wall, door, wall, wall, wall, roof}, true);
    // The slab stands on the floor, a hair above it, so that no face is cut.
    add_box(oven, {0.4, 0.25, 0.05}, {1.6, 0.75, 0.2}, {1, 1, 1}, {slab, slab, slab, slab, slab, slab}, false);
    scene.camera = {{1.98, 0.06, 0.85}, {0.7, 0.6, 0.2}, 70.0};
    return scene;
}

} // namespace scenes
