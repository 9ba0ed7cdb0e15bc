// Scenes with known radiosity, ready to be baked and measured.
#pragma once

#include <difusa/scene/scene.h>
#include <difusa/study/references/reference.h>

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// One channel, in W/m².
struct ReferenceCase {
    std::string name;
    Scene scene;
    std::shared_ptr<const Reference> exact;

    /// The normal of the ideal surface at a point of the mesh; null: the mesh is the ideal surface.
    std::function<Vec3(const SurfacePoint&)> normal;

    /// The part of the surface that is assessed; null: all. Scenes that represent infinite ones are assessed in the
    /// middle.
    std::function<bool(const Vec3& position)> judged;

    /// Upper bound on the relative error contributed by the mesh or its finite size, 0 if none.
    double mesh_error = 0.0;

    std::vector<double> spacings; ///< from coarse to fine, for a study
    bool smooth = false;          ///< irradiance is smooth on each region: shows orders of convergence
};

struct ReferenceCaseName {
    std::string_view name, about; ///< `about`: the scene, for people
};

/// "ball-over-disc", "manufactured-box", "sphere", "bowl", "plates", "shelf", "cylinder".
std::vector<ReferenceCaseName> reference_cases();
std::vector<std::string> reference_case_names();

/// Throws UsageError for an unknown name, with the nearest one.
void require_reference_case(const std::string& name);

/// Makes the case; throws likewise.
ReferenceCase reference_case(const std::string& name);

/// Two walls at a right angle that emit 1 W/m², of width 1 and infinite along their edge: a piece of them between two
/// symmetry planes. `rho`: of both.
ReferenceCase edge_case(double rho);

/// "shelf" with another length than 24, judged by the infinite one: the middle 2, or a quarter of a short one.
ReferenceCase shelf_of_length(double length);

} // namespace difusa
