// Fuzz target: any bytes as a photometric file.
#include <difusa/core/error.h>
#include <difusa/import/luminaire_file.h>

#include "fuzz_reader.h"

#include <cmath>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        const difusa::Luminaire luminaire =
            difusa::parse_ies({reinterpret_cast<const char*>(data), size}, "no-such-directory/input");
        fuzz::hold(luminaire.distribution != nullptr, "a luminaire has a distribution");
        const double flux = luminaire.distribution->flux();
        fuzz::hold(std::isfinite(flux) && luminaire.distribution->largest() > 0.0, "its flux is finite");
        for (const difusa::Vec3& away :
             {difusa::Vec3(0, 0, -1), difusa::Vec3(0.6, 0.8, 0), difusa::Vec3(-0.6, 0, 0.8)}) {
            const double part = luminaire.distribution->relative(away);
            fuzz::hold(part >= 0.0 && part <= 1.0 + 1e-9, "no intensity exceeds the largest");
        }
        fuzz::hold(luminaire.length >= 0.0 && luminaire.width >= 0.0, "openings are not negative");
    } catch (const difusa::InputError& error) {
        fuzz::hold(std::string_view(error.what()).find("input") != std::string_view::npos, "messages name the file");
    }
    return 0;
}
