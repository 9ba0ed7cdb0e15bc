// Fuzz target: any bytes for the reader ply.
#include "../../plugins/readers/ply.cpp"

#include "fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::read(*difusa_plugin_entry(), data, size);
    return 0;
}
