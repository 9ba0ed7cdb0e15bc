// Fuzz target: any bytes for the reader gltf.
#include "../../plugins/readers/gltf.cpp"

#include "fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    // A mesh may stand in many places, and a primitive may be named by many meshes.
    fuzz::read(*difusa_plugin_entry(), data, size, size * size);
    return 0;
}
