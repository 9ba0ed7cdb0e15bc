#include <difusa/core/random.h>

namespace difusa {

namespace {
__extension__ using Wide = unsigned __int128;
}

RandomStream::RandomStream(std::uint64_t seed, std::string_view purpose, std::uint64_t index) : state_(mix_bits(seed)) {
    for (const char letter : purpose) {
        state_ = mix_bits(state_ + static_cast<unsigned char>(letter) + 0x9e3779b97f4a7c15ULL);
    }
    state_ = mix_bits(state_ ^ mix_bits(index + 0x9e3779b97f4a7c15ULL));
}

std::uint64_t RandomStream::bits() {
    state_ += 0x9e3779b97f4a7c15ULL;
    return mix_bits(state_);
}

double RandomStream::uniform() {
    return static_cast<double>(bits() >> 11) * 0x1.0p-53;
}

std::uint64_t RandomStream::below(std::uint64_t count) {
    // Lemire's multiply-shift; the rejection makes it exactly uniform.
    const std::uint64_t threshold = (0 - count) % count;
    for (;;) {
        const auto product = static_cast<Wide>(bits()) * count;
        if (static_cast<std::uint64_t>(product) >= threshold) {
            return static_cast<std::uint64_t>(product >> 64);
        }
    }
}

} // namespace difusa
