#include <difusa/discretisation/glossy_surfels.h>

namespace difusa {

GlossySurfels::GlossySurfels(const Mesh& mesh, const Surfels& surfels) : regions_(mesh.region_count) {
    in_region_.assign(mesh.glossy.lobes.size() * regions_, 0);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (const Index kind = mesh.glossy.kind(t); kind != none) {
            in_region_[mesh.glossy.kinds[kind].lobe * regions_ + mesh.region[t]] = 1;
        }
    }
    std::vector<Surfels::Piece> pieces;
    first_.reserve(surfels.size() + 1);
    for (Index s = 0; s < surfels.size(); ++s) {
        const auto begin = static_cast<Index>(parts_.size());
        first_.push_back(begin);
        surfels.pieces(s, pieces);
        for (const Surfels::Piece& piece : pieces) {
            const Index kind = mesh.glossy.kind(piece.triangle);
            if (kind == none || !(surfels.area(s) > 0.0)) {
                continue;
            }
            const GlossySurfaces::Kind& gloss = mesh.glossy.kinds[kind];
            Index part = begin;
            while (part < parts_.size() && parts_[part].lobe != gloss.lobe) {
                ++part;
            }
            if (part == parts_.size()) {
                parts_.push_back({s, gloss.lobe});
            }
            parts_[part].reflectance += piece.area / surfels.area(s) * gloss.reflectance;
        }
    }
    first_.push_back(static_cast<Index>(parts_.size()));
}

} // namespace difusa
