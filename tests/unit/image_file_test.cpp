// Pictures of every format, made by hand byte for byte, and what becomes of damaged ones.
#include <difusa/core/error.h>
#include <difusa/import/image_file.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace difusa::image_file_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using Bytes = std::string;

Bytes number(std::uint64_t value, std::size_t bytes, bool big) {
    Bytes text;
    for (std::size_t i = 0; i < bytes; ++i) {
        text += static_cast<char>(value >> 8U * (big ? bytes - 1 - i : i));
    }
    return text;
}

std::uint32_t crc(const Bytes& text) {
    std::uint32_t c = 0xffffffffU;
    for (const char byte : text) {
        c ^= static_cast<unsigned char>(byte);
        for (int k = 0; k < 8; ++k) {
            c = (c & 1U) != 0 ? 0xedb88320U ^ (c >> 1U) : c >> 1U;
        }
    }
    return c ^ 0xffffffffU;
}

Bytes chunk(const Bytes& type, const Bytes& data) {
    return number(data.size(), 4, true) + type + data + number(crc(type + data), 4, true);
}

/// zlib without compression.
Bytes stored(const Bytes& data) {
    std::uint32_t a = 1, b = 0;
    for (const char byte : data) {
        a = (a + static_cast<unsigned char>(byte)) % 65521;
        b = (b + a) % 65521;
    }
    return Bytes("\x78\x01\x01", 3) + number(data.size(), 2, false) + number(~data.size(), 2, false) + data +
           number(b << 16U | a, 4, true);
}

/// colour: 0 grey, 2 RGB, 4 grey and opacity, 6 RGB and opacity. `rows` from the top, without filters.
Bytes png(std::uint32_t width, std::uint32_t height, int bits, int colour, const std::vector<Bytes>& rows,
          const Bytes& extra = {}) {
    Bytes data;
    for (const Bytes& row : rows) {
        data += Bytes(1, '\0') + row;
    }
    return "\x89PNG\r\n\x1a\n" +
           chunk("IHDR", number(width, 4, true) + number(height, 4, true) + static_cast<char>(bits) +
                             static_cast<char>(colour) + Bytes(3, '\0')) +
           extra + chunk("IDAT", stored(data)) + chunk("IEND", "");
}

/// The picture of all formats below:  red    green  black
///                                    blue   white  (0, 51, 102)
const std::vector<Bytes> six{Bytes("\xff\0\0\0\xff\0\0\0\0", 9), Bytes("\0\0\xff\xff\xff\xff\0\x33\x66", 9)};

/// The formula of IEC 61966-2-1, from the other side.
double srgb_of(double linear) {
    return linear <= 0.04045 / 12.92 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

Image decode(const Bytes& bytes, PixelEncoding encoding = PixelEncoding::srgb) {
    std::vector<std::string> notes;
    Image image = decode_image(bytes, "a.png", encoding, notes);
    EXPECT_THAT(notes, IsEmpty());
    return image;
}

std::string refusal(const Bytes& bytes) {
    std::vector<std::string> notes;
    try {
        decode_image(bytes, "folder/a.png", PixelEncoding::srgb, notes);
    } catch (const InputError& error) {
        return error.what();
    }
    ADD_FAILURE() << "accepted";
    return "";
}

void expect_six(const Image& image) {
    ASSERT_EQ(image.width, 3U);
    ASSERT_EQ(image.height, 2U);
    EXPECT_THAT(image.at(0, 0), ElementsAre(1, 0, 0));
    EXPECT_THAT(image.at(1, 0), ElementsAre(0, 1, 0));
    EXPECT_THAT(image.at(2, 0), ElementsAre(0, 0, 0));
    EXPECT_THAT(image.at(0, 1), ElementsAre(0, 0, 1));
    EXPECT_THAT(image.at(1, 1), ElementsAre(1, 1, 1));
    EXPECT_EQ(image.at(2, 1)[0], 0);
    // 0.2 and 0.4 encoded.
    EXPECT_NEAR(srgb_of(image.at(2, 1)[1]), 0.2, 1e-6);
    EXPECT_NEAR(srgb_of(image.at(2, 1)[2]), 0.4, 1e-6);
}

TEST(ImageFile, PngHasItsFirstRowAtTheTop) {
    expect_six(decode(png(3, 2, 8, 2, six)));
}

TEST(ImageFile, LinearPixelsAreKept) {
    const Image image = decode(png(3, 2, 8, 2, six), PixelEncoding::linear);
    EXPECT_THAT(image.at(2, 1), ElementsAre(0.0F, 0.2F, 0.4F));
}

TEST(ImageFile, PngOf16BitsKeepsThemAll) {
    const Bytes row = number(65535, 2, true) + number(257 * 51, 2, true) + number(1, 2, true);
    const Image image = decode(png(1, 1, 16, 2, {row}));
    EXPECT_EQ(image.at(0, 0)[0], 1.0F);
    EXPECT_EQ(image.at(0, 0)[1], decode(png(3, 2, 8, 2, six)).at(2, 1)[1]);
    EXPECT_FLOAT_EQ(image.at(0, 0)[2], static_cast<float>(1.0 / 65535.0 / 12.92));
}

TEST(ImageFile, GreyAndPalettesBecomeRgb) {
    EXPECT_THAT(decode(png(2, 1, 8, 0, {Bytes("\0\xff", 2)})).at(1, 0), ElementsAre(1, 1, 1));
    // One bit a pixel: white, black.
    const Image bits = decode(png(2, 1, 1, 0, {"\x80"}));
    EXPECT_THAT(bits.at(0, 0), ElementsAre(1, 1, 1));
    EXPECT_THAT(bits.at(1, 0), ElementsAre(0, 0, 0));
    const Bytes palette = chunk("PLTE", Bytes("\0\0\xff\0\xff\0", 6));
    const Image image = decode(png(2, 1, 8, 3, {Bytes("\1\0", 2)}, palette));
    EXPECT_THAT(image.at(0, 0), ElementsAre(0, 1, 0));
    EXPECT_THAT(image.at(1, 0), ElementsAre(0, 0, 1));
}

TEST(ImageFile, OpacityIsNotedAndDoesNotDarken) {
    std::vector<std::string> notes;
    const Image image =
        decode_image(png(2, 1, 8, 6, {Bytes("\xff\0\0\0\xff\xff\xff\xff", 8)}), "leaf.png", PixelEncoding::srgb, notes);
    EXPECT_THAT(image.at(0, 0), ElementsAre(1, 0, 0));
    EXPECT_THAT(notes, ElementsAre(AllOf(HasSubstr("leaf.png"), HasSubstr("1 of 2 pixels are not opaque"))));
    EXPECT_THAT(decode(png(1, 1, 8, 4, {"\xff\xff"})).at(0, 0), ElementsAre(1, 1, 1));
}

TEST(ImageFile, DamagedPngIsRefusedInSilence) {
    const Bytes good = png(3, 2, 8, 2, six);
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    for (std::size_t length = 0; length < good.size(); ++length) {
        EXPECT_THAT(refusal(good.substr(0, length)), HasSubstr("folder/a.png: ")) << length;
    }
    for (std::size_t at = 0; at < good.size(); ++at) {
        Bytes damaged = good;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
        EXPECT_THAT(refusal(damaged), HasSubstr("folder/a.png: ")) << at;
    }
    // A profile that is none, as many exporters write, is no damage to the pixels.
    expect_six(decode(png(3, 2, 8, 2, six, chunk("iCCP", Bytes("x\0\0", 3) + stored("hello")))));
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(ImageFile, APromiseTooLargeForTheFileTakesNoMemory) {
    EXPECT_THAT(refusal(png(900000, 900000, 8, 2, six)), HasSubstr("900000 by 900000 pixels, which"));
    EXPECT_THAT(refusal("#?RADIANCE\n\n-Y 900000 +X 900000\n"), HasSubstr("cannot hold"));
    EXPECT_THAT(refusal("#?RADIANCE\n\n-Y 0 +X 9\n"), HasSubstr("9 by 0 pixels"));
}

// ---- BMP ------------------------------------------------------------------------------------------------------

/// Rows as they stand in the file, padded.
Bytes bmp(std::int32_t width, std::int32_t height, int bits, const Bytes& palette, const Bytes& rows) {
    const std::size_t data_at = 54 + palette.size();
    return "BM" + number(data_at + rows.size(), 4, false) + number(0, 4, false) + number(data_at, 4, false) +
           number(40, 4, false) + number(static_cast<std::uint32_t>(width), 4, false) +
           number(static_cast<std::uint32_t>(height), 4, false) + number(1, 2, false) +
           number(static_cast<std::uint64_t>(bits), 2, false) + Bytes(16, '\0') + number(palette.size() / 4, 4, false) +
           Bytes(4, '\0') + palette + rows;
}

TEST(ImageFile, BmpRunsFromTheBottomOrTheTop) {
    const Bytes upper("\0\0\xff\0\xff\0\0\0\0\1\2\3", 12), lower("\xff\0\0\xff\xff\xff\x66\x33\0\1\2\3", 12);
    expect_six(decode(bmp(3, 2, 24, {}, lower + upper)));
    expect_six(decode(bmp(3, -2, 24, {}, upper + lower)));
    const Bytes palette("\0\0\xff\0\0\xff\0\0\0\0\0\0\xff\0\0\0\xff\xff\xff\0\x66\x33\0\0", 24);
    expect_six(decode(bmp(3, 2, 8, palette, Bytes("\3\4\5\0\0\1\2\0", 8))));
    const Bytes upper32("\0\0\xff\0\0\xff\0\0\0\0\0\0", 12), lower32("\xff\0\0\0\xff\xff\xff\0\x66\x33\0\0", 12);
    expect_six(decode(bmp(3, 2, 32, {}, lower32 + upper32)));
}

TEST(ImageFile, DamagedBmpIsRefused) {
    const Bytes palette("\0\0\xff\0\0\xff\0\0", 8);
    const Bytes good = bmp(2, 2, 8, palette, Bytes("\0\1\0\0\1\0", 6));
    decode(good);
    for (std::size_t length = 0; length < good.size(); ++length) {
        EXPECT_THAT(refusal(good.substr(0, length)), HasSubstr("folder/a.png")) << length;
    }
    EXPECT_THAT(refusal(bmp(2, 2, 8, palette, Bytes("\0\2\0\0\1\0", 6))), HasSubstr("the colour 2 of 2"));
    EXPECT_THAT(refusal(bmp(2, 2, 16, {}, Bytes(8, '\0'))), HasSubstr("16 bits per pixel"));
    EXPECT_THAT(refusal(bmp(-2, 2, 24, {}, Bytes(8, '\0'))), HasSubstr("0 by 2 pixels"));
}

// ---- Radiance -------------------------------------------------------------------------------------------------

const Bytes header = "#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\n";

TEST(ImageFile, RadianceIsLinear) {
    const Bytes pixels("\x80\x40\x20\x81\x80\x80\x80\x80\0\0\0\0\xff\1\0\x88", 16);
    const Image image = decode(header + "\n-Y 2 +X 2\n" + pixels);
    EXPECT_THAT(image.at(0, 0), ElementsAre(1.0F, 0.5F, 0.25F));
    EXPECT_THAT(image.at(1, 0), ElementsAre(0.5F, 0.5F, 0.5F));
    EXPECT_THAT(image.at(0, 1), ElementsAre(0, 0, 0));
    EXPECT_THAT(image.at(1, 1), ElementsAre(255, 1, 0));
    // Pixels have been multiplied by the exposures.
    const Image exposed = decode(header + "EXPOSURE= 2\nEXPOSURE=2.0\r\n\n-Y 2 +X 2\n" + pixels);
    EXPECT_THAT(exposed.at(0, 0), ElementsAre(0.25F, 0.125F, 0.0625F));
}

TEST(ImageFile, RunsOfRadianceEqualWholePixels) {
    Bytes whole, coded("\2\2\0\x0a", 4), old;
    for (int c = 0; c < 10; ++c) {
        whole += Bytes{static_cast<char>(c < 7 ? 9 : c), '\5', static_cast<char>(40 + c), '\x80'};
    }
    coded += Bytes{'\x87', '\x9' /* 7 of 9 */, '\3', '\7', '\10', '\11', '\x8a', '\5', '\12'};
    for (int c = 0; c < 10; ++c) {
        coded += static_cast<char>(40 + c);
    }
    coded += "\x8a\x80";
    const Image a = decode(header + "\n-Y 1 +X 10\n" + whole), b = decode(header + "\n-Y 1 +X 10\n" + coded);
    EXPECT_EQ(a.pixels, b.pixels);
    // The older form repeats whole pixels: 1 + 2 + 256 of them.
    old = Bytes("\x80\x40\x20\x81\1\1\1\2\1\1\1\1", 12);
    const Image c = decode(header + "\n-Y 1 +X 259\n" + old);
    for (const auto& pixel : c.pixels) {
        EXPECT_THAT(pixel, ElementsAre(1.0F, 0.5F, 0.25F));
    }
}

TEST(ImageFile, DamagedRadianceIsRefused) {
    const Bytes good = header + "\n-Y 1 +X 8\n" + Bytes("\2\2\0\10\x88\1\x88\2\x88\3\x88\x80", 12);
    decode(good);
    for (std::size_t length = 0; length < good.size(); ++length) {
        EXPECT_THAT(refusal(good.substr(0, length)), HasSubstr("folder/a.png")) << length;
    }
    EXPECT_THAT(refusal(header + "\n-Y 1 +X 8\n" + Bytes("\2\2\0\10\x89\1", 6)), HasSubstr("a run of 9 pixels"));
    EXPECT_THAT(refusal(header + "\n-Y 1 +X 8\n" + Bytes("\2\2\0\10\0\1", 6)), HasSubstr("a run of 0 pixels"));
    EXPECT_THAT(refusal(header + "\n-Y 1 +X 3\n" + Bytes("\1\1\1\2\0\0\0\0", 8)), HasSubstr("does not fit"));
    EXPECT_THAT(refusal(header + "\n+Y 1 +X 8\n"), HasSubstr("'+Y 1 +X 8'"));
    EXPECT_THAT(refusal("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n"), HasSubstr("'32-bit_rle_xyze'"));
    EXPECT_THAT(refusal(header + "EXPOSURE=0\n\n-Y 1 +X 1\n"), HasSubstr("exposure"));
}

// ---- TIFF -----------------------------------------------------------------------------------------------------

/// One strip without compression, little-endian. format: 1 whole, 3 real numbers.
Bytes tiff(std::uint32_t width, std::uint32_t height, unsigned bits, unsigned channels, unsigned format,
           const Bytes& pixels) {
    const std::vector<std::array<std::uint32_t, 3>> tags{// tag, type (3: 16 bits, 4: 32 bits), value
                                                         {256, 4, width},
                                                         {257, 4, height},
                                                         {258, 3, bits},
                                                         {259, 3, 1},
                                                         {262, 3, channels < 3 ? 1U : 2U},
                                                         {273, 4, 0},
                                                         {277, 3, channels},
                                                         {278, 4, height},
                                                         {279, 4, static_cast<std::uint32_t>(pixels.size())},
                                                         {339, 3, format}};
    const std::size_t bits_at = 8 + 2 + tags.size() * 12 + 4, formats_at = bits_at + 8, data_at = formats_at + 8;
    Bytes file = Bytes("II*\0", 4) + number(8, 4, false) + number(tags.size(), 2, false), many_bits, many_formats;
    for (const auto& [tag, type, value] : tags) {
        const bool each = tag == 258 || tag == 339;
        const std::uint64_t content = tag == 273                           ? data_at
                                      : each && channels > 2 && tag == 258 ? bits_at
                                      : each && channels > 2               ? formats_at
                                                                           : value;
        file += number(tag, 2, false) + number(type, 2, false) + number(each ? channels : 1, 4, false) +
                number(content, 4, false);
    }
    for (unsigned c = 0; c < 4; ++c) {
        many_bits += number(bits, 2, false);
        many_formats += number(format, 2, false);
    }
    return file + number(0, 4, false) + many_bits + many_formats + pixels;
}

TEST(ImageFile, TiffOfWholeAndRealNumbers) {
    expect_six(decode(tiff(3, 2, 8, 3, 1, six[0] + six[1])));
    EXPECT_THAT(decode(tiff(1, 1, 16, 1, 1, number(65535, 2, false))).at(0, 0), ElementsAre(1, 1, 1));
    Bytes real;
    for (const float value : {7.5F, 0.25F, 0.0F}) {
        real += number(std::bit_cast<std::uint32_t>(value), 4, false);
    }
    EXPECT_THAT(decode(tiff(1, 1, 32, 3, 3, real)).at(0, 0), ElementsAre(7.5F, 0.25F, 0.0F));
    const Bytes negative = number(std::bit_cast<std::uint32_t>(-1.0F), 4, false);
    EXPECT_THAT(refusal(tiff(1, 1, 32, 1, 3, negative)), HasSubstr("column 0, row 0"));
}

TEST(ImageFile, DamagedTiffIsRefusedInSilence) {
    const Bytes good = tiff(3, 2, 8, 3, 1, six[0] + six[1]);
    testing::internal::CaptureStderr();
    for (std::size_t length = 0; length < good.size(); ++length) {
        EXPECT_THAT(refusal(good.substr(0, length)), HasSubstr("folder/a.png")) << length;
    }
    EXPECT_THAT(refusal(tiff(900000, 900000, 8, 3, 1, six[0])), HasSubstr("cannot hold"));
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// ---- JPEG -----------------------------------------------------------------------------------------------------

/// 16 by 16 grey pixels, the upper 8 rows white and the lower ones black: four blocks that are even, so that their
/// constant terms tell everything: 127 times the quantum 8 makes 127 above the middle grey 128.
TEST(ImageFile, JpegOfEvenBlocks) {
    // Differences of constant terms: +127, 0, -255, 0; in bits: size 7 and 8.
    Bytes file("\xff\xd8\xff\xdb\0\x43\0", 7);
    file += Bytes(64, '\x8');
    file += Bytes("\xff\xc0\0\x0b\x08\0\x10\0\x10\1\1\x11\0", 13);
    // Codes of sizes: 00 -> 0, 01 -> 7, 10 -> 8. Codes of the rest: 0 -> end of block.
    file += Bytes("\xff\xc4\0\x16\0\0\3", 7) + Bytes(14, '\0') + Bytes("\0\7\10", 3);
    file += Bytes("\xff\xc4\0\x14\x10\1", 6) + Bytes(15, '\0') + Bytes("\0", 1);
    file += Bytes("\xff\xda\0\x08\1\1\0\0\x3f\0", 10);
    // 01 1111111 0 | 00 0 | 10 00000000 0 | 00 0 and ones to fill: 01111111 10000100 00000000 00011111
    file += Bytes("\x7f\x84\0\x1f\xff\xd9", 6);
    const Image image = decode(file, PixelEncoding::linear);
    ASSERT_EQ(image.width, 16U);
    ASSERT_EQ(image.height, 16U);
    for (std::size_t r = 0; r < 16; ++r) {
        for (std::size_t c = 0; c < 16; ++c) {
            EXPECT_EQ(image.at(c, r)[0], r < 8 ? 1.0F : 0.0F) << c << " " << r;
        }
    }
    testing::internal::CaptureStderr();
    for (std::size_t length = 0; length + 2 < file.size(); ++length) {
        EXPECT_THAT(refusal(file.substr(0, length)), HasSubstr("folder/a.png: ")) << length;
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(ImageFile, OtherFilesAreRefused) {
    EXPECT_THAT(refusal("solid"), HasSubstr("not an image of a supported format"));
    EXPECT_THAT(refusal(""), HasSubstr("not an image of a supported format"));
    std::vector<std::string> notes;
    EXPECT_THROW(read_image("no-such-directory/a.png", PixelEncoding::srgb, notes), InputError);
}

} // namespace
} // namespace difusa::image_file_test
