#include <difusa/import/scene_repetition.h>

namespace difusa {

std::vector<Repetition::Plane> scene_symmetry(const SceneChecks& checks, const JsonValue& from) {
    const std::string what = "a symmetry plane";
    std::vector<Repetition::Plane> planes;
    for (const JsonValue& plane : checks.list(from, quoted("symmetry"))) {
        checks.members(plane, what, {"point", "normal"});
        planes.push_back({checks.position(checks.required(plane, what, "point"), quoted("point")),
                          checks.direction(checks.required(plane, what, "normal"), quoted("normal"))});
    }
    return planes;
}

std::vector<Vec3> scene_periods(const SceneChecks& checks, const JsonValue& from) {
    const std::string what = "a period";
    std::vector<Vec3> periods;
    for (const JsonValue& period : checks.list(from, quoted("periodic"))) {
        checks.members(period, what, {"translation"});
        const JsonValue& translation = checks.required(period, what, "translation");
        periods.push_back(checks.position(translation, quoted("translation")));
        if (periods.back() == Vec3::Zero()) {
            checks.fail(translation, "\"translation\" is zero: the scene cannot repeat where it is");
        }
    }
    return periods;
}

} // namespace difusa
