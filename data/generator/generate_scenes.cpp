// Generates the scenes of data/.
//     generate_scenes [--directory DIR] all
//     generate_scenes [--directory DIR] NAME
//     generate_scenes [--directory DIR] hall
//     generate_scenes [--directory DIR] engine [TRIANGLES]
//     generate_scenes [--directory DIR] room_with_balls TRIANGLES
// `all` means those stored in data/, which must match the output of this program. The last three are too large to
// store.
#include "scenes.h"
#include "write_scene.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using Directory = std::filesystem::path;

struct Kept {
    std::string name;
    std::function<void(const Directory&)> write;
};

const std::vector<Kept>& kept() {
    using namespace scenes;
    static const std::vector<Kept> list{
        {"ball_over_disc", [](const Directory& d) { write_obj(ball_over_disc(), d, "ball_over_disc"); }},
        {"bowl", [](const Directory& d) { write_ply(bowl(), d, "bowl"); }},
        {"cornell_box", [](const Directory& d) { write_scene(cornell_box(), d, "cornell_box"); }},
        {"courtyard", [](const Directory& d) { write_off(courtyard(), d, "courtyard"); }},
        {"daylit_room",
         [](const Directory& d) {
             write_obj(daylit_room(), d, "daylit_room");
             write_text(daylit_room_json(), d / "daylit_room.json");
             write_text(daylit_room_points(), d / "daylit_room_points.csv");
         }},
        {"furnace_box", [](const Directory& d) { write_obj(furnace_box(), d, "furnace_box"); }},
        {"glossy_floor", [](const Directory& d) { write_scene(glossy_floor(), d, "glossy_floor"); }},
        {"greenhouse_row", [](const Directory& d) { write_scene(greenhouse_row(), d, "greenhouse_row"); }},
        {"mirror_double", [](const Directory& d) { write_scene(mirror_double(), d, "mirror_double"); }},
        {"mirror_room", [](const Directory& d) { write_scene(mirror_room(), d, "mirror_room"); }},
        {"mirror_single", [](const Directory& d) { write_scene(mirror_single(), d, "mirror_single"); }},
        {"office",
         [](const Directory& d) {
             write_text(office_json(), d / "office.json");
             write_text(office_luminaire_ies(), d / "office_luminaire.ies");
         }},
        {"oven", [](const Directory& d) { write_scene(oven(), d, "oven"); }},
        {"radiation_shield", [](const Directory& d) { write_scene(radiation_shield(), d, "radiation_shield"); }},
        {"room", [](const Directory& d) { write_off(room(), d, "room"); }},
        {"room_a", [](const Directory& d) { write_scene(room_a(), d, "room_a"); }},
        {"room_b", [](const Directory& d) { write_scene(room_b(), d, "room_b"); }},
        {"room_c", [](const Directory& d) { write_scene(room_c(), d, "room_c"); }},
        {"room_d", [](const Directory& d) { write_scene(room_d(), d, "room_d"); }},
        {"street_canyon", [](const Directory& d) { write_scene(street_canyon(), d, "street_canyon"); }},
        {"ugly", [](const Directory& d) { write_text(ugly_off(), d / "ugly.off"); }},
    };
    return list;
}

std::string usage() {
    std::string text = "usage: generate_scenes [--directory DIR] NAME, NAME one of: all";
    for (const Kept& scene : kept()) {
        text += ", " + scene.name;
    }
    return text + ", hall; or engine [TRIANGLES] (45000 or more), room_with_balls TRIANGLES (2000 or more)";
}

/// Whether the word names a scene generated without a count.
bool is_name(const std::string& word) {
    return word == "all" || word == "hall" ||
           std::any_of(kept().begin(), kept().end(), [&](const Kept& scene) { return scene.name == word; });
}

std::size_t parse_count(const std::string& text) {
    std::size_t count = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
    if (error != std::errc() || end != text.data() + text.size()) {
        throw std::invalid_argument(text + " is not a number of triangles; " + usage());
    }
    return count;
}

void run(std::vector<std::string> words) {
    Directory directory = ".";
    if (words.size() >= 2 && words[0] == "--directory") {
        directory = words[1];
        words.erase(words.begin(), words.begin() + 2);
        std::filesystem::create_directories(directory);
    }
    if (words.size() == 1 && (words[0] == "--help" || words[0] == "-h")) {
        std::printf("%s\n", usage().c_str());
        return;
    }
    if (words.size() == 2 && words[0] == "room_with_balls") {
        scenes::write_obj(scenes::room_with_balls(parse_count(words[1])), directory, "room_with_balls");
        return;
    }
    if ((words.size() == 1 || words.size() == 2) && words[0] == "engine") {
        const std::size_t triangles = words.size() == 2 ? parse_count(words[1]) : 110000;
        scenes::write_scene(scenes::engine(triangles), directory, "engine");
        return;
    }
    if (words.size() == 1 && words[0] == "hall") {
        scenes::write_scene(scenes::hall(), directory, "hall");
        return;
    }
    if (words.size() == 2 && is_name(words[0])) {
        throw std::invalid_argument(words[1] + ": only engine and room_with_balls take a number of triangles; " +
                                    usage());
    }
    bool found = false;
    for (const Kept& scene : kept()) {
        if (words.size() == 1 && (words[0] == "all" || words[0] == scene.name)) {
            scene.write(directory);
            found = true;
        }
    }
    if (!found) {
        throw std::invalid_argument(usage());
    }
}

} // namespace

int main(int argc, char** argv) {
    try {
        run(std::vector<std::string>(argv + 1, argv + argc));
        return 0;
    } catch (const std::invalid_argument& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 2;
    }
}
