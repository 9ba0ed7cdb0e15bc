#include <difusa/radiosity/sensors.h>

#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/core/frame.h>
#include <difusa/core/random.h>
#include <difusa/radiosity/gathering_noise.h>
#include <difusa/radiosity/system.h>
#include <difusa/rays/direction_pool.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

namespace difusa {

namespace {

constexpr std::size_t around_a_sphere = 128, around_an_axis = 32;
constexpr std::size_t probes = 64;
constexpr int parts_of_a_reading = 4;                      ///< gathered apart from each other, for the noise
constexpr std::size_t sensors_at_once = 1024;              ///< the points of that many are in memory
constexpr double noise_decline = 0.75;                     ///< of noise, by the rays (gathering_noise.h)
constexpr double precise = 0.02;                           ///< noise, over what is measured, that needs no further rays
constexpr std::size_t rays_of_few = std::size_t{1} << 20U; ///< of sensors that are read with the most rays at once
constexpr std::size_t rays_again = std::size_t{1} << 24U;  ///< that sensors that are read at once may take again

/// Number of planar sensors that a sensor is the mean of.
std::size_t count_of(SensorKind kind) {
    return kind == SensorKind::planar ? 1 : kind == SensorKind::spherical ? around_a_sphere : around_an_axis;
}

/// Normals of these planar sensors. For a sphere, points of a Fibonacci lattice, randomly turned; around an axis, equal
/// angles from a random one on.
void add_planes(const Sensor& sensor, RandomStream stream, std::vector<SurfacePoint>& points) {
    const auto add = [&](const Vec3& normal) { points.push_back({sensor.position, normal, none, 0.0, 0.0}); };
    const std::size_t count = count_of(sensor.kind);
    const double two_pi = 2.0 * std::numbers::pi;
    if (sensor.kind == SensorKind::planar) {
        add(sensor.axis);
        return;
    }
    const double start = two_pi * stream.uniform();
    if (sensor.kind == SensorKind::cylindrical) {
        Vec3 t, b;
        tangents(sensor.axis, t, b);
        for (std::size_t k = 0; k < count; ++k) {
            const double angle = start + two_pi * static_cast<double>(k) / static_cast<double>(count);
            add(std::cos(angle) * t + std::sin(angle) * b);
        }
        return;
    }
    // A uniform rotation (Shoemake 1992).
    const double s = stream.uniform(), other = two_pi * stream.uniform();
    const Eigen::Quaterniond turn(std::sqrt(s) * std::cos(other), std::sqrt(1.0 - s) * std::sin(start),
                                  std::sqrt(1.0 - s) * std::cos(start), std::sqrt(s) * std::sin(other));
    for (std::size_t k = 0; k < count; ++k) {
        const double z = 1.0 - (2.0 * static_cast<double>(k) + 1.0) / static_cast<double>(count);
        const double r = std::sqrt(1.0 - z * z), angle = two_pi * static_cast<double>(k) / std::numbers::phi;
        add(turn * Vec3(r * std::cos(angle), r * std::sin(angle), z));
    }
}

/// What some sensors of one kind receive, by set and channel.
struct Reading {
    Values direct, indirect; ///< #sensors by the channels of each set in turn
    Values variance;         ///< Irradiance::variance
};

/// Means over the planes of each sensor.
Values means(const Values& planes, std::size_t count) {
    const auto each = static_cast<Eigen::Index>(count);
    Values mean(planes.rows() / each, planes.cols());
    for (Eigen::Index i = 0; i < mean.rows(); ++i) {
        mean.row(i) = planes.middleRows(i * each, each).colwise().mean();
    }
    return mean;
}

class Sensing {
  public:
    Sensing(const Field& field, std::span<const Sensor> sensors, const SensorRays& rays, const ErrorMap* errors,
            std::uint64_t seed, const Execution& execution)
        : field_(field), sensors_(sensors), rays_(rays), errors_(errors), seed_(seed), execution_(execution) {}

    SensorReadings read() {
        const auto count = static_cast<Eigen::Index>(sensors_.size());
        const Eigen::Index columns = field_.parts().smooth.cols();
        direct_.setZero(count, columns);
        indirect_.setZero(count, columns);
        result_.noise.setZero(count, 1);
        result_.error.setZero(errors_ != nullptr ? count : 0, 1);
        // Neighbours of one kind together.
        for (std::size_t begin = 0; begin < sensors_.size();) {
            std::size_t end = begin;
            while (end < sensors_.size() && end - begin < sensors_at_once &&
                   sensors_[end].kind == sensors_[begin].kind) {
                ++end;
            }
            read_some(begin, end);
            begin = end;
        }
        const int channels = field_.channels();
        raise_to_zero(direct_, channels);
        raise_to_zero(indirect_, channels);
        result_.H_direct = three_channels(sum_of_parts(direct_, channels));
        result_.H_indirect = three_channels(sum_of_parts(indirect_, channels));
        result_.H = result_.H_direct + result_.H_indirect;
        if (field_.sets().names.size() > 1 || !field_.sets().names.front().empty()) {
            for (Index set = 0; set < field_.sets().count(); ++set) {
                const Eigen::Index first = static_cast<Eigen::Index>(set) * channels;
                result_.groups.push_back(
                    {field_.sets().names[set],
                     {},
                     three_channels(direct_.middleCols(first, channels) + indirect_.middleCols(first, channels))});
            }
        }
        return std::move(result_);
    }

  private:
    /// Of sensors begin ... end - 1, all of one kind.
    Reading part(std::size_t begin, std::size_t end, std::size_t rays, const std::string& purpose) {
        const std::size_t planes = count_of(sensors_[begin].kind);
        std::vector<SurfacePoint> points;
        points.reserve((end - begin) * planes);
        for (std::size_t i = begin; i < end; ++i) {
            add_planes(sensors_[i], RandomStream(seed_, purpose, i), points);
        }
        const std::size_t each = std::max<std::size_t>(1, rays / parts_of_a_reading / planes);
        const Irradiance H =
            field_.gather(points, each, seed_, purpose + ", from " + std::to_string(begin), execution_);
        result_.rays += H.rays;
        result_.segments += H.segments;
        return {means(H.direct, planes), means(H.indirect, planes),
                means(H.variance, planes) / static_cast<double>(planes)};
    }

    /// Reads these sensors, afresh if they have been read.
    void read(std::size_t begin, std::size_t end, std::size_t rays, const std::string& purpose) {
        constexpr auto parts = static_cast<double>(parts_of_a_reading);
        const auto from = static_cast<Eigen::Index>(begin), count = static_cast<Eigen::Index>(end - begin);
        const int channels = field_.channels();
        auto direct = direct_.middleRows(from, count), indirect = indirect_.middleRows(from, count);
        direct.setZero();
        indirect.setZero();
        Values variance = Values::Zero(count, 1), squares = variance;
        std::vector<Values> totals;
        for (int k = 0; k < parts_of_a_reading; ++k) {
            const Reading one = part(begin, end, rays, purpose + " " + std::to_string(k));
            direct += one.direct / parts;
            indirect += one.indirect / parts;
            variance += one.variance / (parts * parts);
            totals.push_back(sum_of_parts(Values(one.direct + one.indirect), channels));
        }
        const Values mean = sum_of_parts(Values(direct + indirect), channels);
        for (const Values& total : totals) {
            squares += (total - mean).rowwise().squaredNorm();
        }
        result_.noise.middleRows(from, count) =
            noise_of_gathers(squares / (parts * (parts - 1.0)), parts_of_a_reading - 1, variance) / std::sqrt(channels);
    }

    /// The root mean square of the noise of these sensors over what they measure.
    double relative_noise(std::size_t begin, std::size_t end) const {
        const int channels = field_.channels();
        double squares = 0.0;
        for (std::size_t i = begin; i < end; ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            const Values H = sum_of_parts(Values(direct_.row(row) + indirect_.row(row)), channels);
            const double all = H.squaredNorm();
            squares += all > 0.0 ? result_.noise(row, 0) * result_.noise(row, 0) * channels / all : 0.0;
        }
        return std::sqrt(squares / static_cast<double>(end - begin));
    }

    /// All of them with as many rays as the noise of all needs: if noise decided about single sensors, those whose rays
    /// happened to miss a window would be left as they are, since they seem to have little.
    void read_some(std::size_t begin, std::size_t end) {
        const std::size_t count = end - begin;
        const bool are_few = count * rays_.most <= rays_of_few;
        read(begin, end, are_few ? rays_.most : rays_.first, "sensors, part");
        const double noise = are_few ? 0.0 : relative_noise(begin, end);
        if (noise > precise) {
            const double wanted = static_cast<double>(rays_.first) * std::pow(noise / precise, 1.0 / noise_decline);
            const std::size_t most = std::min(rays_.most, std::max(rays_again / count, 4 * rays_.first));
            const auto rays = static_cast<std::size_t>(std::min(wanted, static_cast<double>(most)));
            if (2 * rays >= 3 * rays_.first) {
                read(begin, end, rays, "sensors again, part");
            }
        }
        for (std::size_t i = begin; i < end && errors_ != nullptr; ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            result_.error(row, 0) = std::hypot(result_.noise(row, 0), error_of_surroundings(i));
        }
    }

    /// What the errors on the surfaces that a sensor sees make of its reading.
    double error_of_surroundings(std::size_t number) const {
        const Tracer& tracer = field_.parts().system->tracer();
        RandomStream stream(seed_, "probes of sensors", number);
        std::vector<SurfacePoint> planes;
        add_planes(sensors_[number], RandomStream(seed_, "probed planes", number), planes);
        std::vector<Ray> rays;
        for (std::size_t k = 0; k < probes; ++k) {
            const Vec3& n = planes[k * planes.size() / probes].normal;
            const double u = (static_cast<double>(k) + stream.uniform()) / static_cast<double>(probes);
            const double angle = 2.0 * std::numbers::pi * stream.uniform();
            rays.push_back({sensors_[number].position, cosine_direction(n, u, angle), none});
        }
        std::vector<Hit> hits(rays.size());
        tracer.first_hits(rays, hits);
        std::vector<SurfacePoint> met;
        for (const Hit& hit : hits) {
            if (hit.face != none && hit.front) {
                met.push_back(tracer.mesh().at(hit.face, hit.u, hit.v));
            }
        }
        const ErrorsAt errors = errors_->at(met, execution_.silent());
        const Values local = errors.noise.cwiseAbs2() + errors.discretisation.cwiseAbs2();
        const double carried = (errors.error.cwiseAbs2() - local).cwiseMax(0.0).cwiseSqrt().sum();
        std::map<Index, double> of_surfel; // sums of local errors
        for (std::size_t i = 0; i < met.size(); ++i) {
            const Index s = field_.parts().system->discretisation().surfels->at(met[i].face, met[i].u, met[i].v);
            of_surfel[s] += std::sqrt(local(static_cast<Eigen::Index>(i), 0));
        }
        double squares = carried * carried;
        for (const auto& [surfel, sum] : of_surfel) {
            squares += sum * sum;
        }
        return std::sqrt(squares) / static_cast<double>(probes);
    }

    const Field& field_;
    const std::span<const Sensor> sensors_;
    const SensorRays rays_;
    const ErrorMap* const errors_;
    const std::uint64_t seed_;
    const Execution& execution_;
    Values direct_, indirect_;
    SensorReadings result_;
};

} // namespace

SensorReadings read_sensors(const Field& field, std::span<const Sensor> sensors, const SensorRays& rays,
                            const ErrorMap* errors, std::uint64_t seed, const Execution& execution) {
    if (rays.first < least_sensor_rays) {
        throw UsageError("sensors need at least " + std::to_string(least_sensor_rays) + " rays");
    }
    for (const Sensor& sensor : sensors) {
        if (!sensor.position.allFinite() || !(std::abs(sensor.axis.norm() - 1.0) <= 1e-6)) {
            throw UsageError("a sensor needs a finite position and an axis of unit length");
        }
    }
    return Sensing(field, sensors, rays, errors, seed, execution).read();
}

} // namespace difusa
