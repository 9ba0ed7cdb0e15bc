// Fuzz target: any bytes for the reader stl.
#include "../../plugins/readers/stl.cpp"

#include "fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::read(*difusa_plugin_entry(), data, size);
    return 0;
}
