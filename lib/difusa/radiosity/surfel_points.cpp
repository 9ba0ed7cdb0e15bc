#include <difusa/radiosity/surfel_points.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace difusa {

namespace {

/// A number in a share of [0, 1).
double place_in_share(std::size_t share, std::size_t shares, RandomStream& stream) {
    const double place = (static_cast<double>(share) + stream.uniform()) / static_cast<double>(shares);
    return std::min(place, std::nextafter(1.0, 0.0)); // rounding
}

/// Of each share of [0, 1) one number for each group, in ascending order, with the groups.
std::vector<std::pair<double, Index>> places_in_shares(std::size_t shares, Index groups, RandomStream& stream) {
    std::vector<std::pair<double, Index>> places;
    places.reserve(shares * groups);
    for (std::size_t share = 0; share < shares; ++share) {
        for (Index g = 0; g < groups; ++g) {
            places.emplace_back(place_in_share(share, shares, stream), g);
        }
    }
    std::sort(places.begin(), places.end());
    return places;
}

} // namespace

SurfelPoints draw_surfel_points(const Surfels& surfels, std::span<const double> density, std::size_t shares,
                                Index groups, RandomStream& stream) {
    SurfelPoints points;
    const double all = std::accumulate(density.begin(), density.end(), 0.0);
    if (!(all > 0.0)) {
        return points;
    }
    const std::vector<std::pair<double, Index>> places = places_in_shares(shares, groups, stream);
    std::vector<Surfels::Piece> pieces;
    double below = 0.0;
    for (Index s = 0; s < surfels.size(); ++s) {
        if (!(density[s] > 0.0)) {
            continue;
        }
        below += density[s];
        bool known = false;
        while (points.size() < places.size() && places[points.size()].first * all < below) {
            if (!known) {
                surfels.pieces(s, pieces);
                known = true;
            }
            points.group.push_back(places[points.size()].second);
            const double u = stream.uniform(), v = stream.uniform();
            points.place.push_back(surfels.mesh().shaded(surfels.point_on(pieces, u, v)));
            points.surfel.push_back(s);
            points.weight.push_back(surfels.area(s) * all / (density[s] * static_cast<double>(places.size())));
        }
    }
    DIFUSA_REQUIRE(points.size() == places.size());
    return points;
}

SurfelPoints choose_points(const SurfelPoints& from, std::span<const double> chance, std::size_t shares, Index groups,
                           RandomStream& stream) {
    std::vector<double> all(groups, 0.0), below(groups, 0.0);
    for (std::size_t p = 0; p < from.size(); ++p) {
        all[from.group[p]] += chance[p];
    }
    std::vector<std::vector<double>> place(groups); // from the last to the first
    for (std::vector<double>& each : place) {
        for (std::size_t share = shares; share-- > 0;) {
            each.push_back(place_in_share(share, shares, stream));
        }
    }
    SurfelPoints points;
    for (std::size_t p = 0; p < from.size(); ++p) {
        const Index g = from.group[p];
        below[g] += chance[p];
        while (!place[g].empty() && place[g].back() * all[g] < below[g]) {
            place[g].pop_back();
            points.place.push_back(from.place[p]);
            points.weight.push_back(from.weight[p] * all[g] / (chance[p] * static_cast<double>(shares)));
            points.surfel.push_back(from.surfel[p]);
            points.group.push_back(g);
        }
    }
    DIFUSA_REQUIRE(points.size() == shares * groups || from.size() == 0);
    return points;
}

} // namespace difusa
