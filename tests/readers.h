// For tests of the mesh readers: parsing from memory, comparing soups, and damaging files.
#pragma once

#include <difusa/core/error.h>
#include <difusa/import/reader.h>
#include <difusa/plugin/registry.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

namespace readers {

/// The reader of that name, from the plugins beside the library.
inline std::shared_ptr<difusa::Reader> reader(const std::string& name) {
    static const difusa::Registry registry = difusa::Registry::load();
    return registry.create<difusa::Reader>(name);
}

inline difusa::PolygonSoup parse(const std::string& name, std::string_view content) {
    return reader(name)->parse(content, "folder/test." + name);
}

/// What the reader says about a file it refuses; a failure and "" if it accepts it.
inline std::string refusal(const std::string& name, std::string_view content) {
    try {
        parse(name, content);
    } catch (const difusa::InputError& error) {
        return error.what();
    }
    ADD_FAILURE() << "accepted, and should not be: " << content.substr(0, 500);
    return "";
}

/// All notes in one text.
inline std::string notes(const difusa::PolygonSoup& soup) {
    std::string result;
    for (const std::string& note : soup.notes) {
        result += note + "\n";
    }
    return result;
}

/// Doubles with all their bits, so that NaN equals itself and -0 does not equal 0.
inline std::vector<std::uint64_t> bits(const std::vector<difusa::Vec3>& points) {
    std::vector<std::uint64_t> result;
    for (const difusa::Vec3& p : points) {
        for (int k = 0; k < 3; ++k) {
            result.push_back(std::bit_cast<std::uint64_t>(p[k]));
        }
    }
    return result;
}

/// Equal but for lines and notes.
inline void expect_equal(const difusa::PolygonSoup& a, const difusa::PolygonSoup& b) {
    EXPECT_EQ(bits(a.points), bits(b.points));
    EXPECT_EQ(a.corners, b.corners);
    EXPECT_EQ(a.first_corner, b.first_corner);
    EXPECT_EQ(a.face_material, b.face_material);
    ASSERT_EQ(a.materials.size(), b.materials.size());
    for (std::size_t m = 0; m < a.materials.size(); ++m) {
        EXPECT_EQ(a.materials[m].name, b.materials[m].name);
        EXPECT_TRUE((a.materials[m].reflectance == b.materials[m].reflectance).all()) << "material " << m;
        EXPECT_TRUE((a.materials[m].emission == b.materials[m].emission).all()) << "material " << m;
    }
    ASSERT_EQ(a.point_reflectance.size(), b.point_reflectance.size());
    for (std::size_t i = 0; i < a.point_reflectance.size(); ++i) {
        EXPECT_TRUE((a.point_reflectance[i] == b.point_reflectance[i]).all()) << "point " << i;
    }
}

/// What holds for every soup, however odd its file.
inline void expect_sound(const difusa::PolygonSoup& soup) {
    const std::size_t faces = soup.face_count();
    ASSERT_EQ(soup.first_corner.front(), 0U);
    ASSERT_EQ(soup.first_corner.back(), soup.corners.size());
    for (std::size_t f = 0; f < faces; ++f) {
        ASSERT_LE(soup.first_corner[f], soup.first_corner[f + 1]);
    }
    EXPECT_EQ(soup.face_material.size(), faces);
    EXPECT_TRUE(soup.face_line.empty() || soup.face_line.size() == faces);
    EXPECT_TRUE(soup.point_line.empty() || soup.point_line.size() == soup.points.size());
    EXPECT_TRUE(soup.point_reflectance.empty() || soup.point_reflectance.size() == soup.points.size());
}

/// Cuts a file short at every length: each piece is refused, or is a sound soup that lacks faces or comes with a note.
/// A piece that differs from the file by blanks at its end only may be accepted like the file.
inline void expect_safe_prefixes(const std::string& name, std::string_view content) {
    const difusa::PolygonSoup whole = parse(name, content);
    std::size_t refused = 0;
    for (std::size_t length = 0; length < content.size(); ++length) {
        SCOPED_TRACE("the first " + std::to_string(length) + " bytes of " + std::to_string(content.size()));
        const std::string_view piece = content.substr(0, length);
        try {
            const difusa::PolygonSoup soup = parse(name, piece);
            expect_sound(soup);
            const bool only_blanks = content.find_first_not_of(" \r\n", length) == std::string_view::npos;
            EXPECT_TRUE(soup.face_count() < whole.face_count() || soup.notes.size() > whole.notes.size() ||
                        only_blanks);
        } catch (const difusa::InputError& error) {
            ++refused;
            EXPECT_THAT(error.what(), testing::HasSubstr("test." + name));
        }
    }
    EXPECT_GT(refused, 0U);
}

/// The bytes of numbers, in the order asked for: what a binary file is made of.
class Bytes {
  public:
    explicit Bytes(std::endian order, std::string header = {}) : order_(order), content_(std::move(header)) {}

    template <class T> Bytes& add(std::initializer_list<T> values) {
        for (const T value : values) {
            auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
            if (order_ != std::endian::native) {
                std::reverse(bytes.begin(), bytes.end());
            }
            content_.append(bytes.data(), bytes.size());
        }
        return *this;
    }
    const std::string& content() const { return content_; }

  private:
    std::endian order_;
    std::string content_;
};

} // namespace readers
