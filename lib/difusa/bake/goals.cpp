#include <difusa/bake/goals.h>

#include <difusa/import/file_content.h>
#include <difusa/import/json_tree.h>
#include <difusa/mesh/surface_finder.h>
#include <difusa/plugin/parameters.h>

#include <algorithm>
#include <optional>

namespace difusa {

namespace {

ListedPoint place_of(const JsonChecks& checks, const JsonValue& value) {
    const std::string what = "a place";
    const bool with_normal = checks.list(value, what).size() == 6;
    const std::vector<double> x = checks.numbers(value, what, with_normal ? 6 : 3);
    ListedPoint place{{x[0], x[1], x[2]}, std::nullopt};
    if (with_normal) {
        const Vec3 normal(x[3], x[4], x[5]);
        if (!(normal.norm() > 0.0)) {
            checks.fail(value, "the normal of a place must not be 0");
        }
        place.normal = normal.normalized();
    }
    return place;
}

void add_faces(const JsonChecks& checks, const JsonValue& value, GoalRequest& goal) {
    if (value.kind == JsonValue::Kind::number) {
        const std::size_t face = checks.whole(value, "a face");
        goal.faces.emplace_back(face, face);
        return;
    }
    const std::vector<JsonValue>& ends = checks.list(value, "a face or a range of faces");
    if (ends.size() != 2) {
        checks.fail(value, "a range of faces must be [first, last]");
    }
    goal.faces.emplace_back(checks.whole(ends[0], "the first face of a range"),
                            checks.whole(ends[1], "the last face of a range"));
    if (goal.faces.back().second < goal.faces.back().first) {
        checks.fail(value, "the last face of a range must not come before the first");
    }
}

GoalRequest goal_of(const JsonChecks& checks, const JsonValue& value) {
    const std::string what = "a goal";
    checks.members(value, what, {"name", "materials", "faces", "places"});
    GoalRequest goal;
    goal.name = checks.text(checks.required(value, what, "name"), quoted("name"));
    if (goal.name.empty()) {
        checks.fail(value, "the name of a goal must not be empty");
    }
    const JsonValue *materials = value.find("materials"), *faces = value.find("faces"), *places = value.find("places");
    if ((places != nullptr) == (materials != nullptr || faces != nullptr)) {
        checks.fail(value, "a goal must have either \"places\" or \"materials\" and \"faces\"");
    }
    const auto for_each = [&](const JsonValue* list, const char* name, const auto& use) {
        if (list != nullptr) {
            if (checks.list(*list, quoted(name)).empty()) {
                checks.fail(*list, quoted(name) + " must not be empty");
            }
            std::for_each(list->items.begin(), list->items.end(), use);
        }
    };
    for_each(materials, "materials",
             [&](const JsonValue& item) { goal.materials.push_back(checks.text(item, "a material")); });
    for_each(faces, "faces", [&](const JsonValue& item) { add_faces(checks, item, goal); });
    for_each(places, "places", [&](const JsonValue& item) { goal.places.push_back(place_of(checks, item)); });
    return goal;
}

[[noreturn]] void refuse(const GoalRequest& goal, const std::string& problem) {
    throw InputError("goal \"" + goal.name + "\": " + problem);
}

void check_materials(const GoalRequest& goal, const Scene& scene) {
    std::vector<std::string> names;
    for (const Material& material : scene.materials) {
        names.push_back(material.name);
    }
    for (const std::string& name : goal.materials) {
        if (std::find(names.begin(), names.end(), name) == names.end()) {
            const std::string near = nearest_name(name, names);
            refuse(goal,
                   "there is no material \"" + name + "\"" + (near.empty() ? "" : "; did you mean \"" + near + "\"?"));
        }
    }
}

void check_faces(const GoalRequest& goal, const Mesh& mesh) {
    const Index last = *std::max_element(mesh.original_face.begin(), mesh.original_face.end());
    for (const auto& [first, end] : goal.faces) {
        if (end < first) {
            refuse(goal, "its faces from " + std::to_string(first) + " to " + std::to_string(end) +
                             " are none: the last of a range must not come before the first");
        }
        if (end > last) {
            refuse(goal, "there is no face " + std::to_string(end) + ": the last one is " + std::to_string(last));
        }
    }
}

std::vector<Index> triangles_of(const GoalRequest& goal, const Scene& scene) {
    const Mesh& mesh = scene.mesh;
    check_materials(goal, scene);
    check_faces(goal, mesh);
    std::vector<char> named; // of each material
    for (const Material& material : scene.materials) {
        const auto found = std::find(goal.materials.begin(), goal.materials.end(), material.name);
        named.push_back(found != goal.materials.end() ? 1 : 0);
    }
    std::vector<Index> triangles;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const std::size_t face = mesh.original_face[t];
        if (named[mesh.material[t]] != 0 || std::any_of(goal.faces.begin(), goal.faces.end(), [&](const auto& range) {
                return range.first <= face && face <= range.second;
            })) {
            triangles.push_back(t);
        }
    }
    if (triangles.empty()) {
        refuse(goal, "no face with any area belongs to it");
    }
    return triangles;
}

} // namespace

std::vector<GoalRequest> read_goals(const std::filesystem::path& file) {
    const std::string content = read_file(file);
    const JsonValue root = parse_json(content, file.string());
    const JsonChecks checks(file.string());
    checks.members(root, "the file", {"goals"});
    const JsonValue& list = checks.required(root, "the file", "goals");
    std::vector<GoalRequest> goals;
    for (const JsonValue& item : checks.list(list, quoted("goals"))) {
        GoalRequest goal = goal_of(checks, item);
        if (std::any_of(goals.begin(), goals.end(),
                        [&](const GoalRequest& other) { return other.name == goal.name; })) {
            checks.fail(item, "a second goal is named \"" + goal.name + "\": names must differ");
        }
        goals.push_back(std::move(goal));
    }
    if (goals.empty()) {
        checks.fail(list, "\"goals\" must not be empty");
    }
    return goals;
}

std::vector<Goal> find_goals(const std::vector<GoalRequest>& requests, const Scene& scene, double spacing,
                             const Execution& execution) {
    std::vector<Goal> goals;
    std::optional<SurfaceFinder> surface; // made for the first goal with places
    for (const GoalRequest& request : requests) {
        if (std::any_of(goals.begin(), goals.end(), [&](const Goal& other) { return other.name == request.name; })) {
            refuse(request, "another one has this name: names must differ");
        }
        Goal goal{request.name, {}, {}};
        if (request.places.empty()) {
            goal.triangles = triangles_of(request, scene);
        } else {
            if (!surface) {
                surface.emplace(scene.mesh);
            }
            std::size_t far = 0;
            for (const ListedPoint& wanted : request.places) {
                check_place("goal \"" + request.name + "\": place " + std::to_string(goal.places.size()) +
                                " (counting from 0)",
                            wanted);
                const auto place = surface->nearest(wanted.position, wanted.normal.value_or(Vec3::Zero()));
                if (!place) {
                    refuse(request, "no surface faces the direction of the normal of place " +
                                        std::to_string(goal.places.size()) +
                                        " (counting from 0): turn the normal, or omit it");
                }
                goal.places.push_back(scene.mesh.shaded(place->point));
                far += place->distance > spacing ? 1 : 0;
            }
            if (far > 0) {
                execution.note("goal \"" + request.name + "\": " + std::to_string(far) + " of its " +
                               std::to_string(request.places.size()) +
                               " places are farther from the surface than the site spacing: the light at the nearest "
                               "surface points is meant");
            }
        }
        goals.push_back(std::move(goal));
    }
    return goals;
}

} // namespace difusa
