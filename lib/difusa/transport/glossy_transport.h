// Glossy reflection as a part of light transport, by finite elements in position and direction (dissertation, chapter
// 8): the light that leaves a glossy surface is a sum of basis functions of position times spherical harmonics of
// direction.
#pragma once

#include <difusa/algebra/linear_operator.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/mesh/lobe_harmonics.h>
#include <difusa/transport/glossy_rays.h>
#include <difusa/transport/light_transport.h>
#include <difusa/transport/mirrored.h>

#include <memory>
#include <utility>
#include <vector>

namespace difusa {

/// Let c be the coefficients of pi times the radiance that leaves the glossy surfels in spherical harmonics, in the
/// frame of the world. With x = [b; sky] of the bins and the rays d of the gather points, each with weight w_d:
///     R   what the points of glossy regions reflect: R_jk x = sum_d w_d (F_k(ω_d) - mean F_k + F*_k) x_d. F*_k is the
///         exact mean of F_k (LobeHarmonics), so that an even light from all sides is reflected without error;
///     S   from the points to the surfels, by P Π and times the reflectance of the surfels: the spatial elements;
///     R_g as R, for the light that comes from glossy surfels: x_d = sum_k Y_k(-ω_d) c_k;
///     V   what all points see of c: V_j c = sum_d w_d sum_k Y_k(-ω_d) c_k over the rays that meet glossy surfels.
/// The irradiance is h = W x + V c, c = S R x + S R_g c: the series of glossy reflections in a row is summed to
/// `reflections` terms, so that the whole is a linear operator like any W. Values have the channels in turn if
/// reflectances are coloured (algebra/channel_rows.h); a single column is reflected like the brightest channel.
class GlossyTransport final : public GlossyAddition {
  public:
    /// `plain`: transport to which the rest is added. Keeps references to nothing but shared parts; `discretisation`
    /// is needed while this is made. Throws UsageError if a projection is not local.
    GlossyTransport(std::shared_ptr<const LinearOperator> plain, std::shared_ptr<const GlossyRays> rays,
                    const Discretisation& discretisation, const GlossySurfaces& glossy, int order,
                    const Execution& execution);

    const LinearOperator& matt() const override { return *plain_; }
    const GlossyRays& rays() const { return *rays_; }
    const SphericalHarmonics& harmonics() const { return harmonics_; }
    const LobeHarmonics& lobe(Index number) const { return lobes_[number]; }

    /// 1 if reflectances are grey, else 3.
    int channels() const override { return channels_; }

    /// Pairs of gather point and lobe: the spatial elements; each has `harmonics().count()` coefficients.
    std::size_t elements() const { return point_of_.size(); }

    /// Glossy reflections in a row that are followed, and what the next would at most have of the first, roughly.
    std::size_t reflections() const { return reflections_; }
    double cut_off() const { return cut_off_; }

    std::size_t rows() const override { return plain_->rows(); }
    std::size_t columns() const override { return plain_->columns(); }
    std::size_t entry_count() const override;
    std::size_t bytes() const;
    void apply(const Values& x, Values& y, const Execution& execution) const override;
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override;

    /// V (c + S R_g c + ...): the irradiance at the points from light that leaves glossy surfels. `c`: #parts
    /// (GlossySurfels::parts) times #harmonics rows.
    Values from_surfels(const Values& c, const Execution& execution) const;

    /// Adds to `bins` what points with these rays, of which the surfels are the same, see of each bin over glossy
    /// surfaces, weighted by y, #points by any number of columns: the glossy part of Wᵀ y.
    void add_seen(const GlossyRays& rays, const Values& y, Values& bins, const Execution& execution) const;

    /// For each point and channel, the share of its rays that end on backs after a glossy reflection or more.
    Values lost_on_backs(const Execution& execution) const;

  private:
    Eigen::Index width() const { return static_cast<Eigen::Index>(harmonics_.count()); }
    Eigen::Index coefficient_rows() const;
    void make_elements(const Discretisation& discretisation, const Execution& execution);
    void find_reflections(const Execution& execution);
    double factor(Index part, Eigen::Index column, Eigen::Index columns) const;
    template <class Act> void at_ray(const GlossyRays::Ray& ray, std::vector<double>& Y, const Act& act) const;
    Eigen::MatrixXd scattering(std::size_t element) const;
    Values reflect(const Values* x, const Values* c, bool backs, Eigen::Index columns,
                   const Execution& execution) const;
    void reflect_transposed(const Values& points, Values* x, Values* c, const Execution& execution) const;
    Values to_surfels(const Values& points, const Execution& execution) const;
    Values to_points(const Values& c, const Execution& execution) const;
    Values series(Values c, const Execution& execution) const;
    Values view(const Values& c, const Execution& execution) const;
    Values view_transposed(const GlossyRays& rays, const Values& y, const Execution& execution) const;

    std::shared_ptr<const LinearOperator> plain_;
    std::shared_ptr<const GlossyRays> rays_;
    SphericalHarmonics harmonics_;
    std::vector<LobeHarmonics> lobes_;
    int channels_;
    std::vector<Index> point_of_, lobe_of_; ///< #elements
    std::vector<Index> rotation_of_;        ///< #elements
    std::vector<Eigen::Matrix3d> frames_;   ///< of each rotation
    std::vector<SphericalHarmonics::Rotation> rotations_;
    std::vector<std::vector<std::pair<Index, double>>> weights_; ///< #parts: elements, and their weights (S)
    std::size_t reflections_ = 0;
    double cut_off_ = 0.0;
};

/// The transport with what glossy surfaces reflect, over these elements; itself if nothing is glossy. Throws as above.
LightTransport with_gloss(LightTransport transport, const Discretisation& discretisation, const GlossySurfaces& glossy,
                          int order, const Execution& execution);

/// The glossy part of W, if there is one.
const GlossyTransport* glossy_part(const LinearOperator& W);

} // namespace difusa
