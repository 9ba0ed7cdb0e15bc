// Whether the program runs under AddressSanitizer, known when it runs: the same object files of the tests are linked
// with the plain library and with the instrumented one.
#pragma once

extern "C" void __asan_init() __attribute__((weak)); // NOLINT: the name that every version of the runtime exports

namespace difusa::test {

/// True under AddressSanitizer, where everything takes about ten times as long.
inline bool sanitized() {
    return __asan_init != nullptr;
}

} // namespace difusa::test
