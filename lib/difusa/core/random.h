// Seeded random streams. A stream is identified by (seed, purpose, index), so that site 17 draws the same numbers
// whichever thread handles it, and two purposes never share a sequence.
#pragma once

#include <cstdint>
#include <string_view>

namespace difusa {

/// Small fast generator: a Weyl sequence through the finalizer of SplitMix64 (Steele, Lea and Flood 2014).
class RandomStream {
  public:
    RandomStream(std::uint64_t seed, std::string_view purpose, std::uint64_t index = 0);

    /// 64 equally likely bits.
    std::uint64_t bits();

    /// Uniform in [0,1), a multiple of 2^-53.
    double uniform();

    /// Uniform in {0, ..., count-1}; count > 0.
    std::uint64_t below(std::uint64_t count);

  private:
    std::uint64_t state_;
};

/// A permutation of the 64-bit numbers without visible patterns (the finalizer of SplitMix64).
constexpr std::uint64_t mix_bits(std::uint64_t x) {
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31U);
}

} // namespace difusa
