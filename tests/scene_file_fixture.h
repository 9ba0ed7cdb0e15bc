// For tests of scene files: a folder with a square to be named in them.
#pragma once

#include <difusa/core/error.h>
#include <difusa/import/scene_file.h>
#include <difusa/plugin/registry.h>

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "scratch_directory.h"

namespace difusa::test {

inline const std::string square_off = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

/// A picture of 2 by 1 pixels, black and white, as BMP.
inline std::string black_and_white() {
    std::string bmp("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\2\0\0\0\1\0\0\0\1\0\x18\0", 30);
    return bmp + std::string(24, '\0') + std::string(3, '\0') + std::string(3, '\xff') + std::string(2, '\0');
}

/// 64 by 32 pixels of radiance 1, and one of 256 in the row and column given (-1: none).
inline std::string bright_spot(int row, int column) {
    std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n";
    for (int r = 0; r < 32; ++r) {
        for (int c = 0; c < 64; ++c) {
            hdr += std::string("\x80\x80\x80", 3) + (r == row && c == column ? '\x89' : '\x81');
        }
    }
    return hdr;
}

class SceneFile : public testing::Test {
  protected:
    void SetUp() override { write("square.off", square_off); }
    void write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
    }
    PolygonSoup read(const std::string& text) const {
        write("scene.json", text);
        return read_scene(registry_, folder_ / "scene.json");
    }
    /// A scene with one square, and these further members.
    PolygonSoup with(const std::string& members) const {
        return read("{\"difusa_scene\": 1,\n\"meshes\": [{\"file\": \"square.off\"}],\n" + members + "}");
    }
    PolygonSoup with_mesh(const std::string& members) const {
        return read("{\"difusa_scene\": 1, \"materials\": {\"a\": {\"reflectance\": 0.25}, \"b\": {}},\n\"meshes\": "
                    "[{\"file\": \"square.off\",\n" +
                    members + "}]}");
    }
    template <class F> std::string refusal(F read_it) const {
        try {
            read_it();
        } catch (const InputError& error) {
            return error.what();
        }
        ADD_FAILURE() << "accepted";
        return "";
    }
    std::string refused(const std::string& text) const {
        return refusal([&] { read(text); });
    }
    std::string refused_with(const std::string& members) const {
        return refusal([&] { with(members); });
    }
    std::string refused_mesh(const std::string& members) const {
        return refusal([&] { with_mesh(members); });
    }
    ScratchDirectory folder_;
    Registry registry_ = Registry::load();
};

} // namespace difusa::test
