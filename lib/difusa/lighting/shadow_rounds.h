// How many rounds of shadow rays a light with an extent gets.
#pragma once

#include <cstddef>

namespace difusa {

/// Shadow rays are cast in rounds, each evenly over the light: first pilots, which decide how many rounds follow, then
/// these, of which alone the visible share is the mean. Were pilots counted, or the rounds stopped as soon as some agree,
/// the mean would be biased: where a small part of the light is in sight, rounds that see nothing agree.
struct ShadowRounds {
    static constexpr std::size_t most = 15; ///< that follow

    /// `penumbra`: whether the pilots saw some of the light but not all; `least`: rounds that follow in any case.
    static std::size_t after(bool penumbra, std::size_t least) { return penumbra ? most : least; }
};

} // namespace difusa
