// A number that tells whether data are the same.
#pragma once

#include <difusa/core/random.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <vector>

namespace difusa {

/// 64 bits that depend on every bit added and on the order of adding: different data have the same fingerprint only by
/// a chance of 2^-64. No protection against somebody who looks for such data.
class Fingerprint {
  public:
    void add(std::uint64_t word) { state_ = mix_bits(state_ ^ word) + 0x9e3779b97f4a7c15ULL; }

    /// The bits of the number: -0 differs from 0.
    void add(double number) {
        std::uint64_t word = 0;
        std::memcpy(&word, &number, sizeof word);
        add(word);
    }

    void add(std::string_view bytes) {
        add(static_cast<std::uint64_t>(bytes.size()));
        for (std::size_t at = 0; at < bytes.size(); at += sizeof(std::uint64_t)) {
            const std::string_view piece = bytes.substr(at, sizeof(std::uint64_t));
            std::uint64_t word = 0;
            std::memcpy(&word, piece.data(), piece.size());
            add(word);
        }
    }

    template <class T> void add(const std::vector<T>& numbers) {
        static_assert(std::is_arithmetic_v<T>);
        add(static_cast<std::uint64_t>(numbers.size()));
        for (const T number : numbers) {
            if constexpr (std::is_floating_point_v<T>) {
                add(static_cast<double>(number));
            } else {
                add(static_cast<std::uint64_t>(number));
            }
        }
    }

    std::uint64_t value() const { return mix_bits(state_); }

  private:
    std::uint64_t state_ = 0;
};

} // namespace difusa
