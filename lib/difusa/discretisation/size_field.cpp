#include <difusa/discretisation/size_field.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace difusa {

SizeField::SizeField(std::vector<SurfacePoint> points, const std::vector<Index>& region, std::vector<double> sizes,
                     double largest, Index region_count)
    : points_(std::move(points)), region_(region), least_(region_count), largest_(largest), smallest_(largest) {
    DIFUSA_REQUIRE(points_.size() == region.size());
    assign(std::move(sizes));
    std::vector<std::vector<Index>> members(region_count);
    for (std::size_t i = 0; i < points_.size(); ++i) {
        members[region[i]].push_back(static_cast<Index>(i));
    }
    trees_.resize(region_count);
    for (Index r = 0; r < region_count; ++r) {
        if (!members[r].empty()) {
            trees_[r].emplace(points_, std::move(members[r]));
        }
    }
}

void SizeField::assign(std::vector<double> sizes) {
    DIFUSA_REQUIRE(points_.size() == sizes.size());
    sizes_ = std::move(sizes);
    smallest_ = largest_;
    std::fill(least_.begin(), least_.end(), largest_);
    for (std::size_t i = 0; i < sizes_.size(); ++i) {
        least_[region_[i]] = std::min(least_[region_[i]], sizes_[i]);
        smallest_ = std::min(smallest_, sizes_[i]);
    }
    DIFUSA_REQUIRE(smallest_ > 0.0);
}

double SizeField::at(const Vec3& x, Index region) const {
    return trees_[region] ? trees_[region]->envelope(x, sizes_, least_[region], slope, largest_) : largest_;
}

double SizeField::bound_below(double limit, const Vec3& x, Index region) const {
    if (largest_ < limit) {
        return largest_;
    }
    return trees_[region] ? trees_[region]->first_below(x, sizes_, least_[region], slope, limit) : limit;
}

double SizeField::spacing_of(double largest, int level) {
    return largest * std::pow(2.0, -0.5 * level);
}

double SizeField::rounded(double largest, double size) {
    return spacing_of(largest, std::max(0, static_cast<int>(std::ceil(2.0 * std::log2(largest / size) - 0.5))));
}

} // namespace difusa
