#include <difusa/output/point_table.h>

#include <difusa/bake/thermal.h>
#include <difusa/core/error.h>
#include <difusa/core/photometry.h>
#include <difusa/core/text.h>

#include <cmath>
#include <optional>
#include <utility>

namespace difusa {

namespace {

/// Appends a number. Throws InternalError for a value that is no result.
void append(std::string& text, double value) {
    DIFUSA_REQUIRE(std::isfinite(value), "after `" + text.substr(text.find_last_of('\n') + 1) + "`");
    text += exact_text(value);
}

/// A name as a field of the table: quoted if necessary.
std::string quoted_name(const std::string& name) {
    return name.find_first_of(",\"\n\r") == std::string::npos ? name : csv_quoted(name);
}

/// The table, line by line.
class ValueTable {
  public:
    ValueTable(const BakeResult& result, const std::vector<GroupValues>& groups)
        : result_(result), grids_(!result.options.grids.empty()), errors_(result.error.has_value()) {
        text_ = grids_ ? "grid," : "";
        text_ += "x,y,z,surface_x,surface_y,surface_z,normal_x,normal_y,normal_z,distance,face";
        if (result.scene->thermal) {
            thermal_ = listed_state(result);
            text_ += ",temperature,net_flux,radiosity,irradiance,emissivity";
            text_ += errors_ ? ",error_estimate\n" : "\n";
            return;
        }
        std::vector<std::string> names{"radiosity",           "irradiance",  "irradiance_direct",
                                       "irradiance_indirect", "reflectance", "emission"};
        for (const GroupValues& group : groups) {
            names.insert(names.end(), {"radiosity_of_" + group.name, "irradiance_of_" + group.name});
        }
        for (const std::string& name : names) {
            for (const char* channel : {"_R", "_G", "_B"}) {
                text_ += "," + quoted_name(name + channel);
            }
        }
        if (result.photometric) {
            text_ += ",luminance,illuminance,illuminance_direct,illuminance_indirect";
            for (const GroupValues& group : groups) {
                text_ += "," + quoted_name("illuminance_of_" + group.name);
            }
        }
        text_ += errors_ ? ",error_estimate" : "";
        text_ += errors_ ? ",irradiance_error" : "";
        text_ += errors_ && result.photometric ? ",illuminance_error\n" : "\n";
    }

    void add_listed(std::size_t i) {
        const PointValues& values = result_.listed_values;
        const SurfacePoint& found = result_.listed[i];
        text_ += grids_ ? "," : "";
        started_ = false;
        write(result_.options.at[result_.listed_number[i]].position);
        write(found.position);
        write(found.normal);
        write(result_.listed_distance[i]);
        write(result_.scene->mesh.original_face[found.face]);
        if (thermal_) {
            for (const Values* column : {&thermal_->temperature, &thermal_->net_flux, &thermal_->radiosity,
                                         &thermal_->irradiation, &thermal_->emissivity}) {
                write((*column)(static_cast<Eigen::Index>(i), 0));
            }
            if (result_.listed_errors) {
                write(result_.listed_errors->error(static_cast<Eigen::Index>(i), 0));
            }
            text_ += "\n";
            return;
        }
        for (const Values* column :
             {&values.B, &values.H, &values.H_direct, &values.H_indirect, &values.rho, &values.E}) {
            write(*column, i);
        }
        for (const GroupValues& group : values.groups) {
            write(group.B, i);
            write(group.H, i);
        }
        if (result_.photometric) {
            write(luminance_of_diffuse(values.B.row(static_cast<Eigen::Index>(i)))(0, 0));
            write_illuminances(values, i);
        }
        if (result_.listed_errors) {
            write(result_.listed_errors->error(static_cast<Eigen::Index>(i), 0));
            if (knows_error_of_irradiance(result_)) {
                write_error_of_irradiance(result_.listed_errors->irradiance, i);
            } else {
                leave_out(result_.photometric ? 2 : 1);
            }
        }
        text_ += "\n";
    }

    void add_sensor(std::size_t i) {
        const SensorReadings& values = result_.readings;
        const PlacedSensor& placed = result_.sensors[i];
        text_ += grids_ ? (placed.grid == none ? "" : quoted_name(result_.options.grids[placed.grid].on)) + "," : "";
        started_ = false;
        write(placed.listed == none ? placed.sensor.position : result_.options.at[placed.listed].position);
        leave_out(3);
        write(placed.sensor.axis);
        leave_out(2 + 3);
        for (const Values* column : {&values.H, &values.H_direct, &values.H_indirect}) {
            write(*column, i);
        }
        leave_out(6);
        for (const GroupValues& group : values.groups) {
            leave_out(3);
            write(group.H, i);
        }
        if (result_.photometric) {
            leave_out(1);
            write_illuminances(values, i);
        }
        if (errors_) {
            leave_out(1);
            write_error_of_irradiance(values.error, i);
        }
        text_ += "\n";
    }

    std::string text() && { return std::move(text_); }

  private:
    void separate() {
        text_ += started_ ? "," : "";
        started_ = true;
    }
    void write(double value) {
        separate();
        append(text_, value);
    }
    void write(const Vec3& v) {
        for (const double coordinate : v) {
            write(coordinate);
        }
    }
    void write(const Values& values, std::size_t row) {
        for (Eigen::Index c = 0; c < 3; ++c) {
            write(values(static_cast<Eigen::Index>(row), c));
        }
    }
    /// `values`: PointValues or SensorReadings.
    template <class Read> void write_illuminances(const Read& values, std::size_t row) {
        const auto write_one = [&](const Values& H) {
            write(illuminance_of(H.row(static_cast<Eigen::Index>(row)))(0, 0));
        };
        write_one(values.H);
        write_one(values.H_direct);
        write_one(values.H_indirect);
        for (const GroupValues& group : values.groups) {
            write_one(group.H);
        }
    }
    void leave_out(int fields) {
        for (int k = 0; k < fields; ++k) {
            separate();
        }
    }
    void write_error_of_irradiance(const Values& errors, std::size_t row) {
        const double error = errors(static_cast<Eigen::Index>(row), 0);
        write(error);
        if (result_.photometric) {
            write(lumens_per_watt * error);
        }
    }

    static ThermalValues listed_state(const BakeResult& result) {
        std::vector<Index> material;
        std::vector<Vec3> place;
        for (const SurfacePoint& point : result.listed) {
            material.push_back(result.scene->mesh.material[point.face]);
            place.push_back(point.position);
        }
        return thermal_values(result, result.listed_values.H, material, place);
    }

    const BakeResult& result_;
    const bool grids_, errors_;
    std::optional<ThermalValues> thermal_; ///< of a thermal scene, at the listed places
    std::string text_;
    bool started_ = false; ///< the line has a field
};

} // namespace

std::string point_table(const BakeResult& result) {
    ValueTable table(result, result.listed.empty() ? result.readings.groups : result.listed_values.groups);
    std::size_t listed = 0, sensor = 0; // in the order of the list, then the grids
    for (std::size_t i = 0; i < result.options.at.size(); ++i) {
        if (listed < result.listed.size() && result.listed_number[listed] == i) {
            table.add_listed(listed++);
        } else {
            table.add_sensor(sensor++);
        }
    }
    while (sensor < result.sensors.size()) {
        table.add_sensor(sensor++);
    }
    return std::move(table).text();
}

} // namespace difusa
