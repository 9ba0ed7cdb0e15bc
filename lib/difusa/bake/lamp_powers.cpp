#include <difusa/bake/lamp_powers.h>

#include <difusa/algebra/nonnegative.h>
#include <difusa/bake/sensing.h>
#include <difusa/core/digits.h>
#include <difusa/core/error.h>
#include <difusa/core/photometry.h>
#include <difusa/core/text.h>
#include <difusa/scene/light_groups.h>

#include <algorithm>
#include <cmath>

namespace difusa {

namespace {

/// Which groups are lamps.
std::vector<char> lamps_of(const Scene& scene, const LightSets& sets) {
    std::vector<char> lamp(sets.count(), sets.names.front().empty() ? 0 : 1); // no name: there is no light
    for (std::size_t i = 0; i < scene.suns.size(); ++i) {
        if ((scene.suns[i].irradiance > 0.0).any()) {
            lamp[sets.sun[i]] = 0;
        }
    }
    if (scene.has_sky()) {
        lamp[sets.sky] = 0;
    }
    return lamp;
}

std::string four_digits(double value) {
    return with_digits(value, 4);
}

} // namespace

double LampPowers::rms() const {
    return std::sqrt((after - wanted).array().square().mean());
}

std::string LampPowers::text() const {
    const std::string unit = photometric ? " lux" : " W/m²";
    std::string all = "lamps:";
    bool more = false;
    for (const auto& [name, factor] : factors) {
        all += " " + name + " x " + four_digits(factor) + ",";
        more = more || factor > 1.0;
    }
    all += " for " + four_digits(wanted.mean()) + unit + " at " +
           counted(static_cast<std::size_t>(after.size()), "place") + ": " + four_digits(after.minCoeff()) + " to " +
           four_digits(after.maxCoeff()) + ", rms deviation " + four_digits(rms()) +
           " (before: " + four_digits(before.minCoeff()) + " to " + four_digits(before.maxCoeff()) +
           "; of sun and sky, which stay as they are, " + four_digits(fixed) + " on average)";
    if (too_bright > 0) {
        all += "; sun and sky alone exceed the level at " + counted(too_bright, "place");
    }
    return all + (more ? "; factors above 1 ask for more than the lamps emit now" : "");
}

LampPowers lamp_powers(const BakeResult& result, const Eigen::VectorXd& wanted) {
    const auto listed = static_cast<Eigen::Index>(result.listed.size());
    const auto places = listed + static_cast<Eigen::Index>(result.sensors.size());
    if (places == 0) {
        throw UsageError("--solve-lamps: needs places, --at or --grid");
    }
    DIFUSA_REQUIRE(wanted.size() == places);
    const LightSets& sets = result.field().sets();
    const std::vector<char> is_lamp = lamps_of(*result.scene, sets);
    const double unit = result.photometric ? lumens_per_watt : 1.0;
    LampPowers powers;
    powers.wanted = wanted;
    powers.photometric = result.photometric;
    Eigen::MatrixXd A(places, 0);
    Eigen::VectorXd fixed = Eigen::VectorXd::Zero(places);
    const bool dark = sets.names.front().empty();
    for (std::size_t set = 0; set < sets.count() && !dark; ++set) {
        Eigen::VectorXd own(places);
        if (listed > 0) {
            own.head(listed) = unit * (result.listed_values.groups[set].H * luminance_weights);
        }
        if (places > listed) {
            own.tail(places - listed) = unit * (result.readings.groups[set].H * luminance_weights);
        }
        if (is_lamp[set] == 0) {
            fixed += own;
            continue;
        }
        A.conservativeResize(Eigen::NoChange, A.cols() + 1);
        A.col(A.cols() - 1) = own;
        powers.factors.emplace_back(sets.names[set], 0.0);
    }
    if (A.cols() == 0 || !(A.maxCoeff() > 0.0)) {
        throw UsageError(
            "--solve-lamps: the scene has no lamp whose light reaches the places: emitting materials, point "
            "lights and luminaires are lamps, suns and skies are not");
    }
    const Eigen::VectorXd x = nonnegative_least_squares(A, wanted - fixed);
    for (Eigen::Index k = 0; k < x.size(); ++k) {
        powers.factors[static_cast<std::size_t>(k)].second = x[k];
    }
    powers.before = A.rowwise().sum() + fixed;
    powers.after = A * x + fixed;
    powers.fixed = fixed.mean();
    powers.too_bright = static_cast<std::size_t>((fixed.array() > wanted.array()).count());
    return powers;
}

BakeResult relight_lamps(const Registry& registry, const SavedTransport& saved, const RelightOptions& options,
                         double wanted, LampPowers& powers, const Execution& execution) {
    if (options.bake.at.empty() && options.bake.grids.empty()) {
        throw UsageError("--solve-lamps: needs places, --at or --grid");
    }
    constexpr double most = 1e30; // as in scene files
    if (!(wanted > 0.0 && wanted <= most)) {
        throw UsageError("--solve-lamps: the level must be above 0, and at most 1e30");
    }
    RelightOptions apart = options;
    apart.bake.light_groups = true;
    apart.evaluate = false;
    BakeResult groups = relight(registry, saved, apart, execution);
    read_places(groups, nullptr, execution);
    const auto places = static_cast<Eigen::Index>(groups.listed.size() + groups.sensors.size());
    powers = lamp_powers(groups, Eigen::VectorXd::Constant(places, wanted));
    RelightOptions solved = options;
    solved.factors.insert(solved.factors.end(), powers.factors.begin(), powers.factors.end());
    BakeResult result = relight(registry, saved, solved, execution);
    result.journal.note(powers.text());
    return result;
}

} // namespace difusa
