// The infinite shelf of the lectures (L 33-34): a floor, a back and a ceiling, open in front.
#pragma once

#include <difusa/study/references/reference.h>

#include <array>
#include <vector>

namespace difusa {

/// In this order everywhere: A, the floor z = 0 facing up; B, the back x = 0 facing along x; C, the ceiling z = b
/// facing down. Floor and ceiling reach from x = 0 to a; all are infinite along y, and nothing is in front.
struct ShelfParameters {
    double a = 1.0, b = 1.0;                     ///< depth and height, unit of the scene
    std::array<double, 3> E = {1.0, 0.0, 0.0};   ///< emission, W/m²
    std::array<double, 3> rho = {0.5, 0.5, 0.5}; ///< reflectance, in [0, 1)
};

/// The classical solution with one patch for each surface (L 32-33): B_i = E_i + rho_i sum_j F_ij B_j with the closed
/// form factors of `shelf` (form_factors.h). It is what is left of the exact one if the radiosity of each surface is
/// taken for constant, which in a shelf it is not. Throws UsageError for parameters out of range.
std::array<double, 3> shelf_patches(const ShelfParameters& parameters);

/// The exact light, point by point. In the cross-section two elements at a distance r with angles t1, t2 to their
/// normals exchange cos t1 cos t2 / (2 r) per length: floor to back x z/(2 r³), floor to ceiling b²/(2 r³). The
/// integral equation is solved by Nyström's method with Gauss panels that halve towards the corners, where the kernel
/// has the size of the distance to them. Error below 1e-7 of the largest radiosity, except nearer to a corner than 1e-4
/// of the smaller of a and b.
class Shelf final : public Reference {
  public:
    /// Throws UsageError if a parameter is outside its range, or one length is more than 16 times the other.
    explicit Shelf(const ShelfParameters& parameters);

    /// On the surface that faces as n does.
    ReferenceLight at(const Vec3& x, const Vec3& n) const override;

    /// The mean radiosity of each surface.
    std::array<double, 3> mean_radiosity() const;

    /// A bound of what a shelf of finite length lacks, B_infinite - B, at points at least `ends` from both ends, W/m².
    /// From a point, what is further along y than t has directions within the angle psi of the y axis, tan psi = d/t,
    /// with the diagonal d of the cross-section: a share q(t) = 2 (psi - sin psi cos psi)/pi of the view, two segments
    /// of Nusselt's disc. A walk that has left the shelf after k steps has made one longer than ends/k, so, as for
    /// parallel plates, with the largest reflectance rho:
    ///     max_j B_j sum_k (rho^k - rho^{k+1}) min(1, k q(ends/k)).
    double missing(double ends) const;

  private:
    struct Node {
        std::size_t surface;
        double s, weight; ///< distance from x = 0 on A and C, from z = 0 on B; of the quadrature
    };
    double kernel(std::size_t surface, double s, const Node& from) const;
    ShelfParameters parameters_;
    std::vector<Node> nodes_;
    std::vector<double> B_; ///< #nodes
};

} // namespace difusa
