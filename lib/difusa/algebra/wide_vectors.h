// Loops over many columns with the widest vectors that the processor has.
#pragma once

#include <atomic>

namespace difusa {

#if defined(__x86_64__) && defined(__GNUC__)
template <class Work> [[gnu::flatten, gnu::target("avx2")]] void call_with_avx2(const Work& work) {
    work();
}
#endif

/// Calls `work()`, compiled for vectors of four numbers (AVX2) where the processor has them: for loops that do the
/// same with each column, compiled with -O3. The choice does not change the bits: AVX2 does not include fused
/// multiplication and addition, so that products and sums are rounded one by one unless the compiler is told of a
/// processor that fuses them.
template <class Work> void with_wide_vectors(const Work& work) {
#if defined(__x86_64__) && defined(__GNUC__)
    if (__builtin_cpu_supports("avx2") > 0) {
        call_with_avx2(work);
        return;
    }
#endif
    work();
}

/// To be called for each term of a sum over which columns are accumulated one beside the other: else GCC takes two
/// terms at a time, and no vectors.
inline void one_term_at_a_time() {
    std::atomic_signal_fence(std::memory_order_seq_cst); // of the compiler alone
}

} // namespace difusa
