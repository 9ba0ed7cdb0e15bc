#include <difusa/output/basis_files.h>

#include <difusa/core/text.h>
#include <difusa/io/field_writers.h>
#include <difusa/version.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <sstream>
#include <utility>

namespace difusa {

namespace {

FieldArray scalar(const std::string& name, const std::vector<double>& values) {
    const Values column = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    return {name, "", {}, column};
}

FieldArray numbers(const std::string& name, const std::vector<Index>& values) {
    return {name, "", {}, std::vector<std::int32_t>(values.begin(), values.end())};
}

std::vector<FieldNote> notes_of(const BasisInspection& inspection) {
    std::vector<FieldNote> notes;
    notes.push_back({"difusa_version", version()});
    notes.push_back({"input", inspection.file});
    for (const auto& [kind, choice] : inspection.plugins) {
        notes.push_back({kind, choice});
    }
    const InspectOptions& options = inspection.options;
    const auto number = [&](const char* name, double value) { notes.push_back({name, std::vector<double>{value}}); };
    notes.push_back({"seed", std::to_string(options.seed)});
    number("spacing", inspection.sites.spacing);
    number("sites", static_cast<double>(inspection.sites.size()));
    number("neighbours", options.neighbours);
    number("output_spacing", options.output_spacing);
    std::vector<double> places;
    for (const Index i : inspection.elements) {
        const Vec3& p = inspection.sites.points[i].position;
        places.insert(places.end(), {p.x(), p.y(), p.z()});
    }
    notes.push_back({"elements", std::vector<double>(inspection.elements.begin(), inspection.elements.end())});
    notes.push_back({"element_sites", places});
    return notes;
}

std::string place(const Vec3& p) {
    return "(" + text_of(p.x()) + ", " + text_of(p.y()) + ", " + text_of(p.z()) + ")";
}

} // namespace

FieldFile field_of(const BasisInspection& inspection) {
    FieldFile field;
    for (const SurfacePoint& vertex : inspection.output.vertices) {
        field.points.push_back(vertex.position);
        field.normals.push_back(vertex.normal);
    }
    field.triangles = inspection.output.triangles;
    for (std::size_t k = 0; k < inspection.elements.size(); ++k) {
        const std::string name = k == 0 ? "element" : "element_" + std::to_string(inspection.elements[k]);
        field.point_arrays.push_back({name, "", {}, Values(inspection.phi.col(static_cast<Eigen::Index>(k)))});
    }
    field.point_arrays.push_back(scalar("sum", inspection.sum));
    field.point_arrays.push_back(scalar("lebesgue", inspection.lebesgue));
    field.point_arrays.push_back(numbers("overlap", inspection.overlap));
    field.point_arrays.push_back(numbers("nearest_site", inspection.nearest));
    std::vector<Index> face;
    for (const Index f : inspection.output.face) {
        face.push_back(inspection.mesh.original_face[f]);
    }
    field.cell_arrays = {numbers("original_face_id", face)};
    field.notes = notes_of(inspection);
    field.quality = "element";
    return field;
}

FieldFile sites_of(const BasisInspection& inspection) {
    FieldFile field;
    std::vector<Index> element, face;
    for (std::size_t i = 0; i < inspection.sites.size(); ++i) {
        const SurfacePoint& site = inspection.sites.points[i];
        field.points.push_back(site.position);
        field.normals.push_back(site.normal);
        element.push_back(static_cast<Index>(i));
        face.push_back(inspection.mesh.original_face[site.face]);
    }
    std::vector<Index> shown(inspection.sites.size(), 0);
    for (const Index i : inspection.elements) {
        shown[i] = 1;
    }
    field.point_arrays = {numbers("element", element),
                          numbers("shown", shown),
                          scalar("radius", inspection.sites.radius),
                          scalar("reach", inspection.reach),
                          scalar("area", inspection.sites.area),
                          scalar("at_own_site", inspection.at_own_site),
                          numbers("original_face_id", face),
                          numbers("region", inspection.sites.region)};
    field.notes = notes_of(inspection);
    field.quality = "radius";
    return field;
}

std::string summary_of(const BasisInspection& inspection) {
    std::ostringstream text;
    text << inspection.file << ": " << counted(inspection.diagnosis.file_faces, "face") << ", "
         << counted(inspection.mesh.triangles.size(), "triangle") << ", area " << inspection.mesh.area << "\n";
    for (const auto& [kind, choice] : inspection.plugins) {
        text << kind << ": " << choice << "\n";
    }
    text << "elements: " << inspection.sites.size() << " at spacing " << inspection.sites.spacing << "\n";
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (std::size_t v = 0; v < inspection.sum.size(); ++v) {
        if (inspection.counts(v)) {
            least = std::min(least, inspection.sum[v]);
            most = std::max(most, inspection.sum[v]);
        }
    }
    text << "sum: " << least << " to " << most << ", differs from 1 by at most "
         << std::max(std::abs(least - 1.0), std::abs(most - 1.0)) << "\n";
    if (inspection.left_out > 0.0) {
        text << "no element on " << 100.0 * inspection.left_out
             << " % of the surface, which is covered: no site of its own is in sight\n";
    }
    text << "overlap: " << inspection.mean_overlap << " on average, at most "
         << *std::max_element(inspection.overlap.begin(), inspection.overlap.end()) << "\n";
    text << "sum of absolute values (Lebesgue): " << inspection.mean_lebesgue << " on average, at most "
         << *std::max_element(inspection.lebesgue.begin(), inspection.lebesgue.end()) << "\n";
    for (std::size_t k = 0; k < inspection.elements.size(); ++k) {
        const Index i = inspection.elements[k];
        const SurfacePoint& site = inspection.sites.points[i];
        const auto phi = inspection.phi.col(static_cast<Eigen::Index>(k));
        text << "element " << i << ": site at " << place(site.position) << " on face "
             << inspection.mesh.original_face[site.face] << ", radius " << inspection.sites.radius[i] << ", reach "
             << inspection.reach[i] << ", integral " << inspection.sites.area[i] << "; from " << phi.minCoeff()
             << " to " << phi.maxCoeff() << ", " << inspection.at_own_site[i] << " at its site\n";
    }
    return text.str();
}

void write_inspection(const BasisInspection& inspection, const std::filesystem::path& field,
                      const std::filesystem::path& sites, const Execution& execution) {
    execution.phase("write");
    WholeFile field_file(field);
    write_finite_field(field_of(inspection), field, field_file, {});
    std::unique_ptr<WholeFile> sites_file;
    if (!sites.empty()) {
        sites_file = std::make_unique<WholeFile>(sites);
        write_finite_field(sites_of(inspection), sites, *sites_file, {});
    }
    if (execution.progress != nullptr) {
        execution.progress->check();
    }
    field_file.commit();
    if (sites_file) {
        sites_file->commit();
    }
}

} // namespace difusa
