// Basis `patch-constant` (L 29): the surface is refined to triangles of the size that the spacing says, the patches,
// and element i is 1 on patch i, 0 elsewhere. The sites are the centres (sampler `patch-centres`). A partition of unity
// that interpolates, of first order.
//
// With graded sites (--adaptive) patches are quartered where it helps, and there is a constant for each of these
// elements, while patches send light as a whole: substructuring (L 31; Cohen, Greenberg, Immel and Brock 1986).
//
// With `display=gouraud` the equation is the same, but what is shown is linear on each patch between values at its
// vertices, which are extrapolated from the patches (L 53). A vertex e inside of the surface has the mean of the
// patches around it. For a vertex b on a border, where the surface ends, turns sharply, or is of another material, (b +
// e)/2 is the mean m of the patches around b, with e the value inside that is nearest: b = 2 m - e. As the slide says
// this with squares, "(Bb+Be)/2=(B1+B2)/2" and at a corner "(Ba+Be)/2 = B1", e is the mean of the inner vertices of
// these patches; if there is none, b = m. Coefficients are weighted by areas in no mean, as on the slide.
#include <difusa/discretisation/mesh_basis.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace {

using difusa::Index;

class PatchConstant final : public difusa::MeshBasis {
  public:
    explicit PatchConstant(const difusa::Parameters& parameters) : gouraud_(parameters.word("display") == "gouraud") {}

    std::string sampler() const override { return "patch-centres"; }

    bool can_be_subdivided() const override { return !gouraud_; }

    void bind(const difusa::Mesh& mesh, const difusa::SiteSet& sites, const difusa::Execution& execution) override {
        MeshBasis::bind(mesh, sites, execution);
        if (gouraud_) {
            extrapolate();
        }
    }

    void evaluate(const difusa::SurfacePoint& x, difusa::BasisRow& row) const override {
        row.clear();
        const Index own = element_at(patches().at(x));
        if (own != difusa::none) {
            row.element.push_back(own);
            row.weight.push_back(1.0);
        }
    }
    using Basis::evaluate;

    bool displays_otherwise() const override { return gouraud_; }

    void display(const difusa::SurfacePoint& x, difusa::BasisRow& row) const override {
        if (!gouraud_) {
            evaluate(x, row);
            return;
        }
        row.clear();
        const difusa::PatchMesh::Place place = patches().at(x);
        std::map<Index, double> sum;
        for (std::size_t k = 0; k < 3; ++k) {
            for (const auto& [patch, weight] : vertex_[patches().corners(place.patch)[k]]) {
                sum[patch] += place.weight[k] * weight;
            }
        }
        for (const auto& [patch, weight] : sum) {
            if (const Index own = element(patch); own != difusa::none) {
                row.element.push_back(own);
                row.weight.push_back(weight);
            }
        }
    }

  protected:
    bool on_vertices() const override { return false; }

  private:
    using Weights = std::vector<std::pair<Index, double>>; ///< of patches

    /// A vertex is inside if every edge from it is that of two patches.
    std::vector<char> inner_vertices() const {
        std::map<std::pair<Index, Index>, int> uses;
        const auto edge = [](Index a, Index b) { return std::pair(std::min(a, b), std::max(a, b)); };
        for (Index f = 0; f < patches().size(); ++f) {
            const auto& c = patches().corners(f);
            for (std::size_t k = 0; k < 3; ++k) {
                ++uses[edge(c[k], c[(k + 1) % 3])];
            }
        }
        std::vector<char> inner(patches().vertex_count(), 1);
        for (const auto& [ends, count] : uses) {
            if (count < 2) {
                inner[ends.first] = inner[ends.second] = 0;
            }
        }
        return inner;
    }

    static void add(std::map<Index, double>& sum, const Weights& weights, double factor) {
        for (const auto& [patch, weight] : weights) {
            sum[patch] += factor * weight;
        }
    }

    void extrapolate() {
        const std::vector<char> inner = inner_vertices();
        std::vector<std::vector<Index>> around(patches().vertex_count());
        for (Index f = 0; f < patches().size(); ++f) {
            for (const Index v : patches().corners(f)) {
                around[v].push_back(f);
            }
        }
        vertex_.resize(around.size());
        for (std::size_t v = 0; v < around.size(); ++v) {
            for (const Index f : around[v]) {
                vertex_[v].emplace_back(f, 1.0 / static_cast<double>(around[v].size()));
            }
        }
        std::vector<std::pair<std::size_t, Weights>> at_border;
        for (std::size_t v = 0; v < around.size(); ++v) {
            std::vector<Index> inside;
            for (const Index f : around[v]) {
                for (const Index other : patches().corners(f)) {
                    if (inner[v] == 0 && inner[other] != 0) {
                        inside.push_back(other);
                    }
                }
            }
            std::sort(inside.begin(), inside.end());
            inside.erase(std::unique(inside.begin(), inside.end()), inside.end());
            if (inside.empty()) {
                continue;
            }
            std::map<Index, double> sum;
            add(sum, vertex_[v], 2.0);
            for (const Index e : inside) {
                add(sum, vertex_[e], -1.0 / static_cast<double>(inside.size()));
            }
            at_border.emplace_back(v, Weights(sum.begin(), sum.end()));
        }
        for (auto& [v, weights] : at_border) {
            vertex_[v] = std::move(weights);
        }
    }

    bool gouraud_;
    std::vector<Weights> vertex_; ///< #vertices, if they are shown: its value by the patches; sum 1
};

} // namespace

DIFUSA_PLUGIN(basis, "patch-constant", PatchConstant,
              "One value for each triangle of the refined mesh, of the classical method (L 29).",
              {{"display",
                difusa::ParameterSpec::Type::word,
                "flat",
                "what is shown: the patches, or linear between vertex values extrapolated from them (L 53)",
                0,
                0,
                {"flat", "gouraud"}}})
