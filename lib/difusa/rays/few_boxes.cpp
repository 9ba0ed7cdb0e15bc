#include <difusa/rays/few_boxes.h>

#include <cmath>

namespace difusa {

namespace {

using Box = FewBoxes::Box;

constexpr std::size_t most_pairwise = 64, most_boxes = 8;

/// Half of the surface.
double size_of(const Box& box) {
    const Vec3 s = box.sizes();
    return s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
}

/// Unites pairs of neighbours along the longest side of all.
void unite_neighbours(std::vector<Box>& boxes) {
    Box all;
    for (const Box& box : boxes) {
        all.extend(box);
    }
    Eigen::Index axis = 0;
    all.sizes().maxCoeff(&axis);
    std::stable_sort(boxes.begin(), boxes.end(),
                     [&](const Box& a, const Box& b) { return a.center()[axis] < b.center()[axis]; });
    std::vector<Box> united;
    for (std::size_t i = 0; i < boxes.size(); i += 2) {
        united.push_back(i + 1 < boxes.size() ? boxes[i].merged(boxes[i + 1]) : boxes[i]);
    }
    boxes = std::move(united);
}

/// Unites the two for which this adds least; false if none touch and there are few.
bool unite_two(std::vector<Box>& boxes) {
    std::size_t first = 0, second = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        for (std::size_t j = i + 1; j < boxes.size(); ++j) {
            const bool touch = boxes[i].intersects(boxes[j]);
            if (!touch && boxes.size() <= most_boxes) {
                continue;
            }
            const double added =
                touch ? -1.0 : size_of(boxes[i].merged(boxes[j])) - size_of(boxes[i]) - size_of(boxes[j]);
            if (added < least) {
                least = added;
                first = i;
                second = j;
            }
        }
    }
    if (second == 0) {
        return false;
    }
    boxes[first].extend(boxes[second]);
    boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(second));
    return true;
}

} // namespace

FewBoxes::FewBoxes(std::vector<Box> boxes, double magnitude) : boxes_(std::move(boxes)), margin_(magnitude * 0x1p-30) {
    while (boxes_.size() > most_pairwise) {
        unite_neighbours(boxes_);
    }
    while (unite_two(boxes_)) {
    }
    for (Box& box : boxes_) {
        box.min().array() -= margin_;
        box.max().array() += margin_;
    }
}

void FewBoxes::above(const Vec3& foot, const Vec3& normal, std::vector<Box>& above) const {
    above.clear();
    for (const Box& box : boxes_) {
        const double highest = normal.dot(box.center() - foot) + 0.5 * normal.cwiseAbs().dot(box.sizes());
        if (highest > 0.0) { // the box is grown by more than rounding
            above.push_back(box);
        }
    }
}

} // namespace difusa
