#include <difusa/output/gradient_table.h>

#include <difusa/core/text.h>

#include <algorithm>
#include <vector>

namespace difusa {

namespace {

/// Lines of one goal.
class GradientLines {
  public:
    GradientLines(const std::string& goal, std::string& table) : start_(csv_quoted(goal) + ","), table_(table) {}

    void add(const std::string& kind, const std::string& name, const Rgb& value) {
        table_ += start_ + kind + "," + csv_quoted(name);
        for (const double each : value) {
            table_ += "," + exact_text(each);
        }
    }
    void add_gradient(const Eigen::RowVectorXd& gradient) {
        for (Eigen::Index c = 0; c < 3; ++c) {
            table_ += "," + exact_text(gradient[gradient.size() == 1 ? 0 : c]);
        }
        table_ += "\n";
    }
    void add_no_gradient() { table_ += ",,,\n"; }

  private:
    std::string start_;
    std::string& table_;
};

/// By the emission of each face of the file: #faces by #channels.
Values gradients_of_faces(const BakeResult& result, const GoalGradient& gradient) {
    const Mesh& mesh = result.scene->mesh;
    const Surfels& surfels = *result.system->discretisation().surfels;
    const Index last = *std::max_element(mesh.original_face.begin(), mesh.original_face.end());
    Values all = Values::Zero(static_cast<Eigen::Index>(last) + 1, gradient.of_surfels.cols());
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < surfels.size(); ++s) {
        surfels.pieces(s, pieces);
        for (const Surfels::Piece& piece : pieces) {
            all.row(static_cast<Eigen::Index>(mesh.original_face[piece.triangle])) +=
                piece.area / surfels.area(s) * gradient.of_surfels.row(static_cast<Eigen::Index>(s));
        }
    }
    return all;
}

Values emissions_of_faces(const BakeResult& result, Eigen::Index count) {
    const Scene& scene = *result.scene;
    Values all = Values::Zero(count, 3);
    for (std::size_t t = 0; t < scene.mesh.triangles.size(); ++t) {
        all.row(static_cast<Eigen::Index>(scene.mesh.original_face[t])) =
            scene.materials[scene.mesh.material[t]].emission.matrix().transpose();
    }
    return all;
}

} // namespace

std::string gradient_table(const BakeResult& result, std::span<const GoalGradient> gradients, bool faces) {
    std::string table = "goal,kind,name,value_r,value_g,value_b,gradient_r,gradient_g,gradient_b\n";
    const std::vector<std::string>& groups = result.field().sets().names;
    const std::vector<char> used = result.scene->used_materials();
    for (const GoalGradient& gradient : gradients) {
        GradientLines lines(gradient.name, table);
        lines.add("mean", "", gradient.value);
        lines.add_no_gradient();
        for (std::size_t set = 0; set < groups.size(); ++set) {
            lines.add("group", groups[set], Rgb::Ones());
            lines.add_gradient(gradient.groups.row(static_cast<Eigen::Index>(set)));
        }
        for (std::size_t m = 0; m < result.scene->materials.size(); ++m) {
            if (used[m] == 0) {
                continue;
            }
            const Material& material = result.scene->materials[m];
            lines.add("emission", material.name, material.emission);
            lines.add_gradient(gradient.emission.row(static_cast<Eigen::Index>(m)));
            lines.add("reflectance", material.name, material.vertex_colours ? Rgb(Rgb::Ones()) : material.reflectance);
            lines.add_gradient(gradient.reflectance.row(static_cast<Eigen::Index>(m)));
        }
        if (faces) {
            const Values of_faces = gradients_of_faces(result, gradient);
            const Values now = emissions_of_faces(result, of_faces.rows());
            for (Eigen::Index f = 0; f < of_faces.rows(); ++f) {
                lines.add("face", std::to_string(f), now.row(f).transpose().array());
                lines.add_gradient(of_faces.row(f));
            }
        }
    }
    return table;
}

} // namespace difusa
