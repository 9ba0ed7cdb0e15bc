#include <difusa/study/method_study.h>

#include <difusa/core/text.h>
#include <difusa/import/shapes.h>
#include <difusa/io/chart.h>
#include <difusa/study/reference_case.h>
#include <difusa/study/references/ball_over_disc.h>

#include <array>
#include <cstdio>
#include <utility>

namespace difusa {

std::optional<Scene> coarse_scene(const std::string& case_name) {
    if (case_name != "ball-over-disc") {
        return std::nullopt;
    }
    const BallOverDiscParameters p;
    Scene scene = reference_case(case_name).scene;
    Mesh ball = sphere(p.r, 2, Front::outside);
    move(ball, Vec3(0, 0, p.h));
    scene.mesh = {};
    add(scene.mesh, ball, 0);
    add(scene.mesh, disc(p.R, 6), 1);
    return scene;
}

std::vector<ComparedMethod> classical_and_meshless(const BakeOptions& common) {
    struct MethodChoice {
        const char *name, *basis, *directions, *direct;
    };
    constexpr std::array<MethodChoice, 6> choices{
        {{"patches, hemicube", "patch-constant", "hemicube", "interpolated"},
         {"patches, hemicube, Gouraud", "patch-constant:display=gouraud", "hemicube", "interpolated"},
         {"vertices, hemicube", "vertex-linear", "hemicube", "interpolated"},
         {"vertices, hemicube, exact direct light", "vertex-linear", "hemicube", "exact"},
         {"meshless, all light in the basis", "moving-least-squares", "fibonacci", "interpolated"},
         {"meshless", "moving-least-squares", "fibonacci", "exact"}}};
    std::vector<ComparedMethod> methods;
    for (const MethodChoice& choice : choices) {
        BakeOptions bake = common;
        bake.basis = choice.basis;
        bake.sampler.clear();
        bake.projection.clear();
        bake.directions = choice.directions;
        bake.direct = choice.direct;
        methods.push_back({choice.name, std::move(bake)});
    }
    return methods;
}

std::vector<ComparedMethod> defaults_and_others(const BakeOptions& common) {
    BakeOptions even = common;
    even.adaptive = false;
    std::vector<ComparedMethod> methods{{"defaults: moving-least-squares, graded", common}, {"evenly spaced", even}};
    methods.front().bake.adaptive = true;
    for (const char* const basis : {"normalized-radial", "shepard", "radial"}) {
        methods.push_back({std::string("evenly spaced, ") + basis, even});
        methods.back().bake.basis = basis;
    }
    BakeOptions old = even;
    old.basis = "normalized-radial";
    old.projection = "natural";
    old.directions = "low-discrepancy";
    old.rays = 1024;
    methods.push_back({"defaults of version 0.1.0", old});
    return methods;
}

std::vector<MethodTrial> compare_methods(const Registry& registry, const KnownLight& light,
                                         const std::vector<ComparedMethod>& methods,
                                         const std::vector<std::size_t>& sites, const Execution& execution,
                                         const std::function<void(const MethodTrial&)>& tell) {
    std::vector<MethodTrial> trials;
    for (const ComparedMethod& method : methods) {
        for (const std::size_t count : sites) {
            BakeOptions own = method.bake;
            own.sites = count;
            own.spacing = 0.0;
            const std::vector<EstimateTrial> one = try_estimate(registry, light, own, 1, execution, [](const auto&) {});
            trials.push_back({light.name, method.name, one.front()});
            tell(trials.back());
        }
    }
    return trials;
}

std::string method_header() {
    return "| scene | method | sites | transport, MB | processor, s | error |\n|---|---|---|---|---|---|\n";
}

std::string method_row(const MethodTrial& t) {
    std::array<char, 96> numbers{};
    std::snprintf(numbers.data(), numbers.size(), "%zu | %.2f | %.2f | %.2g %%", t.trial.sites,
                  1e-6 * static_cast<double>(t.trial.transport_bytes), t.trial.field_seconds(),
                  100.0 * t.trial.relative_error());
    return "| " + t.scene + " | " + t.method + " | " + numbers.data() + " |\n";
}

std::string method_csv_header() {
    return "scene,method,sites,transport_bytes,processor_seconds,error_W_per_m2,reflected_W_per_m2,relative_error\n";
}

std::string method_csv_row(const MethodTrial& t) {
    return csv_quoted(t.scene) + "," + csv_quoted(t.method) + "," + std::to_string(t.trial.sites) + "," +
           std::to_string(t.trial.transport_bytes) + "," + text_of(t.trial.field_seconds()) + "," +
           text_of(t.trial.total) + "," + text_of(t.trial.reflected) + "," + text_of(t.trial.relative_error()) + "\n";
}

std::string method_chart(const std::vector<MethodTrial>& trials, const std::string& title,
                         const std::vector<MeasuredElsewhere>& elsewhere) {
    Chart chart;
    chart.title = trials.empty() ? "" : trials.front().scene + ": " + title;
    chart.x_title = "processor time, s";
    chart.y_title = "rms error relative to the reflected light";
    chart.x_log = chart.y_log = true;
    for (const MethodTrial& t : trials) {
        chart.add(t.method, t.trial.field_seconds(), t.trial.relative_error());
    }
    for (const MeasuredElsewhere& measured : elsewhere) {
        chart.add(measured.name, measured.seconds, measured.error);
        chart.series.back().dashed = true;
    }
    return svg_of(chart);
}

} // namespace difusa
