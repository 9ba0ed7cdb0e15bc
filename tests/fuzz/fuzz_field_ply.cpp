// Fuzz target: any bytes as a field in a .ply file.
#include "fuzz_field.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::read_file_of(data, size, [](const auto& file) { fuzz::check(difusa::read_ply(file)); });
    return 0;
}
