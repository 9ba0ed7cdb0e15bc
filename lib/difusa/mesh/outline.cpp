#include <difusa/mesh/outline.h>

#include <algorithm>

namespace difusa {

std::size_t distinct_places(const Outline& outline) {
    if (outline.size() == 3) { // almost always
        const Index a = outline[0].place, b = outline[1].place, c = outline[2].place;
        return 1U + (b != a ? 1U : 0U) + (c != a && c != b ? 1U : 0U);
    }
    std::vector<Index> places;
    places.reserve(outline.size());
    for (const Corner& corner : outline) {
        places.push_back(corner.place);
    }
    std::sort(places.begin(), places.end());
    return static_cast<std::size_t>(std::unique(places.begin(), places.end()) - places.begin());
}

void remove_repetitions(Outline& outline) {
    // In place: outline[0 .. kept) is the part that is already clean.
    std::size_t kept = 0;
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const Corner corner = outline[i];
        if (kept >= 1 && outline[kept - 1].place == corner.place) {
            continue;
        }
        if (kept >= 2 && outline[kept - 2].place == corner.place) {
            --kept;
            continue;
        }
        outline[kept++] = corner;
    }
    // The same where the end meets the start.
    std::size_t begin = 0;
    while (kept - begin >= 2) {
        if (outline[kept - 1].place == outline[begin].place || outline[kept - 2].place == outline[begin].place) {
            --kept;
        } else if (outline[kept - 1].place == outline[begin + 1].place) {
            ++begin;
        } else {
            break;
        }
    }
    outline.resize(kept);
    outline.erase(outline.begin(), outline.begin() + static_cast<std::ptrdiff_t>(begin));
}

bool make_canonical(Outline& outline) {
    const auto least = std::min_element(outline.begin(), outline.end(),
                                        [](const Corner& a, const Corner& b) { return a.place < b.place; });
    std::rotate(outline.begin(), least, outline.end());
    if (outline.size() < 3 || outline[1].place < outline.back().place) {
        return false;
    }
    std::reverse(outline.begin() + 1, outline.end());
    return true;
}

} // namespace difusa
