// Fuzz target: any bytes for the reader obj, as an OBJ file and as a material library.
#include "../../plugins/readers/obj.cpp"

#include "fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::read(*difusa_plugin_entry(), data, size);
    try {
        const difusa::MaterialLibrary library =
            difusa::parse_material_library({reinterpret_cast<const char*>(data), size}, "input");
        fuzz::hold(library.materials.size() <= size, "memory in proportion to the file");
        for (const difusa::Material& material : library.materials) {
            fuzz::hold(!material.name.empty(), "materials have names");
        }
    } catch (const difusa::InputError&) {
    }
    return 0;
}
