#include <difusa/discretisation/size_field.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace difusa {

SizeField::SizeField(std::vector<SurfacePoint> points, const std::vector<Index>& region, std::vector<double> sizes,
                     double largest, Index region_count)
    : points_(std::move(points)), region_(region), largest_(largest), smallest_(largest) {
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
    for (const double size : sizes_) {
        smallest_ = std::min(smallest_, size);
    }
    DIFUSA_REQUIRE(smallest_ > 0.0);
}

SizeField::Around SizeField::around(const Vec3& x, Index region) const {
    Around near;
    if (trees_[region]) {
        near.count = trees_[region]->nearest(x, near.point, near.squared_distance);
    }
    return near;
}

double SizeField::least_of(const Around& near) const {
    double least = largest_;
    for (std::size_t k = 0; k < near.count; ++k) {
        least = std::min(least, sizes_[near.point[k]] + slope * std::sqrt(near.squared_distance[k]));
    }
    return least;
}

double SizeField::at(const Vec3& x, Index region) const {
    return least_of(around(x, region));
}

void SizeField::look_around(const Execution& execution) {
    around_.resize(points_.size());
    parallel_for(points_.size(), 256, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            around_[i] = around(points_[i].position, region_[i]);
        }
    });
}

double SizeField::spacing_of(double largest, int level) {
    return largest * std::pow(2.0, -0.5 * level);
}

double SizeField::rounded(double largest, double size) {
    return spacing_of(largest, std::max(0, static_cast<int>(std::ceil(2.0 * std::log2(largest / size) - 0.5))));
}

} // namespace difusa
