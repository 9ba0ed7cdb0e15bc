#include "scenes.h"

namespace scenes {

Surface furnace_box() {
    Surface box;
    box.remarks = {
        "The inside of a closed unit cube that emits and reflects alike everywhere: the white furnace test.",
        "Made by data/generator/furnace_box.cpp.",
        "Exact answer: B = E / (1 - rho) and H = E / (1 - rho) at every point. With E = 1 and rho = 0.2, 0.5, 0.8 in",
        "red, green and blue both are 1.25, 2 and 5 W/m^2.",
    };
    const unsigned m = box.add({"furnace", {0.2, 0.5, 0.8}, {1.0, 1.0, 1.0}});
    add_box(box, {0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, {1, 1, 1}, {m, m, m, m, m, m}, true);
    return box;
}

} // namespace scenes
