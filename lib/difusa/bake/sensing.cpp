#include <difusa/bake/sensing.h>

#include <difusa/bake/sensor_grid.h>
#include <difusa/bake/sensor_lift.h>
#include <difusa/core/error.h>
#include <difusa/core/photometry.h>
#include <difusa/core/text.h>
#include <difusa/mesh/surface_finder.h>
#include <difusa/repair/findings.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace difusa {

namespace {

constexpr std::size_t rays_of_a_sensor = 4096, most_rays_of_a_sensor = 65536; ///< unless the options say
constexpr double touching = SensorLift::touching;

std::string place_name(std::size_t i) {
    return "point " + std::to_string(i) + " (counting from 0)";
}

/// A face that p is behind; none if there is none.
Index face_before(const Vec3& p, const Mesh& mesh) {
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (mesh.normals[t].dot(p - mesh.corner(t, 0)) < -touching * mesh.diameter()) {
            return t;
        }
    }
    return none;
}

/// Whether a convex surface is a room that encloses a volume: it has no borders, and is no sheet with two sides.
bool is_closed(const Mesh& mesh) {
    double volume = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        volume += mesh.areas[t] * mesh.normals[t].dot(mesh.corner(t, 0) - mesh.low) / 3.0;
    }
    return std::find(mesh.twin.begin(), mesh.twin.end(), none) == mesh.twin.end() &&
           std::abs(volume) > touching * std::pow(mesh.diameter(), 3);
}

/// Sensors without a normal of their own.
std::optional<Sensor> sensor_without_normal(const BakeOptions& options, const Vec3& up) {
    const std::string& kind = options.sensor;
    if (kind == "planar") {
        return std::nullopt;
    }
    return Sensor{Vec3::Zero(), up,
                  kind == "horizontal"  ? SensorKind::planar
                  : kind == "spherical" ? SensorKind::spherical
                                        : SensorKind::cylindrical};
}

/// They are in front of what they lie on: a desk, and also its underside, or the ceiling.
std::vector<Sensor> sensors_of_grid(const SensorGrid& grid, const Scene& scene,
                                    const std::optional<Sensor>& without_normal, const SensorLift& lift) {
    const GridPlaces places = places_of_grid(grid, scene);
    Sensor sensor = without_normal.value_or(Sensor{Vec3::Zero(), places.normal, SensorKind::planar});
    std::vector<Sensor> sensors;
    for (const Vec3& position : places.positions) {
        sensor.position = position;
        sensors.push_back(lift(sensor, places.normal, SensorLift::Back::never));
    }
    return sensors;
}

class Placing {
  public:
    explicit Placing(BakeResult& result)
        : result_(result), mesh_(result.scene->mesh), surface_(mesh_), lift_(mesh_),
          without_normal_(sensor_without_normal(result.options, result.up)) {}

    void place(std::size_t i) {
        const ListedPoint& wanted = result_.options.at[i];
        const bool snap = result_.options.snap || (!wanted.normal && !without_normal_);
        if (without_normal_ && result_.options.snap) {
            throw UsageError("--sensor " + result_.options.sensor + ": measures where it stands: omit --snap");
        }
        if (snap) {
            const auto place = surface_.nearest(wanted.position, wanted.normal.value_or(Vec3::Zero()));
            if (!place) {
                throw InputError("--at: no surface faces the direction of the normal of " + place_name(i) +
                                 ": turn the normal, or omit it");
            }
            list(i, *place);
            return;
        }
        Sensor sensor = without_normal_.value_or(Sensor{});
        sensor.position = wanted.position;
        sensor.axis = without_normal_ ? sensor.axis : *wanted.normal;
        if (sensor.kind == SensorKind::planar) {
            const auto place = surface_.nearest(sensor.position, sensor.axis); // of faces back to back the right one
            if (place && place->distance <= touching * mesh_.diameter() &&
                place->point.normal.dot(sensor.axis) > 1.0 - touching) {
                list(i, *place);
                return;
            }
        }
        sensor = lift_(sensor, sensor.axis, SensorLift::Back::in_plane);
        add({sensor, static_cast<Index>(i), none}, "--at: " + place_name(i));
    }

    void place_grid(std::size_t g) {
        const SensorGrid& grid = result_.options.grids[g];
        for (const Sensor& sensor : sensors_of_grid(grid, *result_.scene, without_normal_, lift_)) {
            add({sensor, none, static_cast<Index>(g)}, "--grid " + grid.on + ": a sensor");
        }
    }

    void note_ignored_normals(const Execution& execution) const {
        const auto& at = result_.options.at;
        const auto ignored = static_cast<std::size_t>(
            std::count_if(at.begin(), at.end(), [](const ListedPoint& point) { return point.normal.has_value(); }));
        if (without_normal_ && ignored > 0) {
            execution.note("the normals of " + counted(ignored, "point") + " of --at are ignored: a " +
                           result_.options.sensor + " sensor has none of its own");
        }
    }

    /// Says which places are far from the surface point that stands for them.
    void note_far(const Execution& execution) const {
        std::size_t far = 0;
        std::string which;
        for (std::size_t k = 0; k < result_.listed.size(); ++k) {
            if (result_.listed_distance[k] > result_.options.spacing && far++ < 3) {
                which += (which.empty() ? "" : "; ") + std::string("number ") +
                         std::to_string(result_.listed_number[k]) + ", " + text_of(result_.listed_distance[k]) +
                         " away";
            }
        }
        if (far > 0) {
            execution.note(std::to_string(far) + " of the " + std::to_string(result_.options.at.size()) +
                           " points of --at " + (far == 1 ? "is" : "are") +
                           " farther from the surface than the site spacing (counting from 0: " + which +
                           (far > 3 ? "; ..." : "") +
                           "): the light reported there is that at the nearest surface point; for what a sensor "
                           "measures in mid-air, give " +
                           (result_.options.snap ? "normals without --snap" : "normals, or --sensor"));
        }
    }

  private:
    void list(std::size_t i, const SurfaceFinder::Found& place) {
        const bool has_normal = result_.options.at[i].normal.has_value() && !result_.options.snap;
        result_.listed.push_back(has_normal ? place.point : mesh_.shaded(place.point));
        result_.listed_distance.push_back(place.distance);
        result_.listed_number.push_back(static_cast<Index>(i));
    }

    void add(const PlacedSensor& placed, const std::string& name) {
        // Nothing is taken to block the view within a convex room.
        if (const Index t = mesh_.convex ? face_before(placed.sensor.position, mesh_) : none; t != none) {
            throw InputError(name + " is outside of the room, behind face " + std::to_string(mesh_.original_face[t]) +
                             ": move it to the front of all faces");
        }
        result_.sensors.push_back(placed);
    }

    BakeResult& result_;
    const Mesh& mesh_;
    const SurfaceFinder surface_;
    const SensorLift lift_;
    const std::optional<Sensor> without_normal_;
};

/// Sensors that receive nothing: most often they stand inside a block, or their coordinates are in another unit. Those
/// of grids spoil the uniformity.
void note_dark(const BakeResult& result, const Execution& execution) {
    std::size_t dark = 0, first = 0, dark_listed = 0, first_listed = 0;
    for (std::size_t i = 0; i < result.sensors.size(); ++i) {
        if (result.readings.H.row(static_cast<Eigen::Index>(i)).maxCoeff() > 0.0) {
            continue;
        }
        if (result.sensors[i].grid != none) {
            first = dark++ == 0 ? i : first;
        } else {
            first_listed = dark_listed++ == 0 ? i : first_listed;
        }
    }
    if (dark_listed > 0) {
        execution.note(
            counted(dark_listed, "sensor") + (dark_listed == 1 ? " of --at receives" : " of --at receive") +
            " no light at all (first at " + coordinates(result.sensors[first_listed].sensor.position) +
            "): they may stand inside of objects, or their coordinates may be in another unit than the scene");
    }
    if (dark > 0) {
        const PlacedSensor& placed = result.sensors[first];
        execution.note(counted(dark, "sensor") + (dark == 1 ? " of grids receives" : " of grids receive") +
                       " no light at all (first on " + result.options.grids[placed.grid].on + ", at " +
                       coordinates(placed.sensor.position) +
                       "): they may stand inside of objects; they count in minimum and uniformity");
    }
}

} // namespace

void open_if_seen_from_outside(BakeResult& result) {
    Mesh& mesh = result.scene->mesh;
    const BakeOptions& options = result.options;
    if (!mesh.convex || (options.at.empty() && options.grids.empty()) || is_closed(mesh)) {
        return;
    }
    const auto is_behind = [&](const Vec3& p) { return face_before(p, mesh) != none; };
    const std::optional<Sensor> without_normal = sensor_without_normal(options, result.up);
    bool outside = false;
    const SensorLift lift(mesh);
    if (!options.snap && !options.at.empty()) {
        outside = std::any_of(options.at.begin(), options.at.end(), [&](const ListedPoint& each) {
            if (!each.normal && !without_normal) {
                return false; // on the surface
            }
            Sensor sensor = without_normal.value_or(Sensor{});
            sensor.position = each.position;
            sensor.axis = without_normal ? sensor.axis : *each.normal;
            return is_behind(each.position) ||
                   is_behind(lift(sensor, sensor.axis, SensorLift::Back::in_plane).position);
        });
    }
    for (std::size_t g = 0; g < options.grids.size() && !outside; ++g) {
        const std::vector<Sensor> sensors = sensors_of_grid(options.grids[g], *result.scene, without_normal, lift);
        outside = std::any_of(sensors.begin(), sensors.end(),
                              [&](const Sensor& sensor) { return is_behind(sensor.position); });
    }
    mesh.convex = !outside;
}

void find_places(BakeResult& result, const Execution& execution) {
    const BakeOptions& options = result.options;
    if (options.at.empty() && options.grids.empty()) {
        return;
    }
    Placing placing(result);
    for (std::size_t i = 0; i < options.at.size(); ++i) {
        check_place("--at: " + place_name(i), options.at[i]);
        placing.place(i);
    }
    for (std::size_t g = 0; g < options.grids.size(); ++g) {
        placing.place_grid(g);
    }
    placing.note_ignored_normals(execution);
    placing.note_far(execution);
}

void note_gathered(const BakeResult& result, const PointValues& values, const char* thing, const Execution& execution) {
    if (const std::size_t count = values.gathered.size(); count > 0 && result.options.final_gather == 0) {
        execution.note("the light of " + counted(count, thing) + " of " + std::to_string(values.B.rows()) +
                       " is gathered with " + std::to_string(values.rays_of_each) +
                       " rays each: no basis function reaches " + (count == 1 ? "it" : "them"));
    }
}

void read_places(BakeResult& result, const ErrorMap* errors, const Execution& execution) {
    const BakeOptions& options = result.options;
    if (!result.listed.empty()) {
        result.listed_values =
            result.field().at(result.listed, options.final_gather, options.seed, "listed", execution);
        note_gathered(result, result.listed_values, "listed place", execution);
        if (errors != nullptr) {
            result.listed_errors = errors->of(result.listed, result.listed_values, execution);
        }
        execution.count("output rays", result.listed_values.rays);
        execution.count("output segments", result.listed_values.segments);
    }
    if (options.sensor_rays > 0 && result.sensors.empty() && !result.listed.empty()) {
        execution.note("--sensor-rays has no effect: all places are on the surface");
    }
    if (!result.sensors.empty()) {
        std::vector<Sensor> sensors;
        for (const PlacedSensor& placed : result.sensors) {
            sensors.push_back(placed.sensor);
        }
        const SensorRays rays = options.sensor_rays > 0
                                    ? SensorRays(options.sensor_rays)
                                    : SensorRays(std::max(rays_of_a_sensor, options.final_gather),
                                                 std::max(most_rays_of_a_sensor, options.final_gather));
        result.readings = read_sensors(result.field(), sensors, rays, errors, options.seed, execution);
        note_dark(result, execution);
        execution.count("output rays", result.readings.rays);
        execution.count("output segments", result.readings.segments);
    }
}

GridSummary summary_of_grid(const BakeResult& result, std::size_t grid) {
    GridSummary summary;
    const double factor = result.photometric ? lumens_per_watt : 1.0;
    double sum = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < result.sensors.size(); ++i) {
        if (result.sensors[i].grid != grid) {
            continue;
        }
        const auto row = static_cast<Eigen::Index>(i);
        const double H = factor * result.readings.H.row(row).dot(luminance_weights);
        summary.least = summary.count == 0 ? H : std::min(summary.least, H);
        summary.most = std::max(summary.most, H);
        sum += H;
        if (result.readings.error.rows() > 0) {
            squares += std::pow(factor * result.readings.error(row, 0), 2);
        }
        ++summary.count;
    }
    const auto count = static_cast<double>(std::max<std::size_t>(summary.count, 1));
    summary.mean = sum / count;
    summary.uniformity = summary.mean > 0.0 ? summary.least / summary.mean : 0.0;
    summary.error = std::sqrt(squares / count);
    return summary;
}

} // namespace difusa
