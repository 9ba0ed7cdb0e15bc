// Pictures are written so that VTK reads back what they say.
#include <difusa/core/colour.h>
#include <difusa/io/image_files.h>

#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/io/field_file.h>
#include <difusa/output/bake_files.h>

#include <scratch_directory.h>

#include <gtest/gtest.h>

#include <cmath>

#include <vtkHDRReader.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

namespace difusa::image_files_test {
namespace {

/// Values of all sizes, whole rows of one value, single pixels that differ, and black.
Image some_picture(std::size_t width, std::size_t height, double magnitude) {
    Image image{width, height, {}};
    RandomStream stream(3, "image");
    for (std::size_t i = 0; i < width * height; ++i) {
        std::array<float, 3> pixel{};
        const std::uint64_t kind = stream.below(4);
        for (float& c : pixel) {
            c = kind == 0   ? 0.0F
                : kind == 1 ? static_cast<float>(magnitude)
                            : static_cast<float>(magnitude * stream.uniform());
        }
        image.pixels.push_back(i % 7 < 4 && i > 0 ? image.pixels.back() : pixel);
    }
    return image;
}

template <class Reader> vtkImageData* read(Reader& reader, const std::string& file) {
    reader.SetFileName(file.c_str());
    reader.Update();
    return reader.GetOutput();
}

TEST(ImageFiles, PngHoldsTheDisplayValuesAsSrgb) {
    const test::ScratchDirectory scratch;
    const Image image = some_picture(37, 11, 1.1); // some beyond white
    const std::string file = scratch / "a.png";
    write_whole_file(file, png_of(image));
    vtkNew<vtkPNGReader> reader;
    vtkImageData* data = read(*reader, file);
    ASSERT_EQ(data->GetDimensions()[0], 37);
    ASSERT_EQ(data->GetDimensions()[1], 11);
    ASSERT_EQ(data->GetNumberOfScalarComponents(), 3);
    ASSERT_EQ(data->GetScalarSize(), 1);
    for (int y = 0; y < 11; ++y) {
        for (int x = 0; x < 37; ++x) {
            for (int c = 0; c < 3; ++c) { // VTK counts rows from the bottom
                const auto value = static_cast<double>(
                    image.at(static_cast<std::size_t>(x), static_cast<std::size_t>(y))[static_cast<std::size_t>(c)]);
                EXPECT_EQ(data->GetScalarComponentAsDouble(x, 10 - y, 0, c),
                          static_cast<double>(std::lround(255.0 * srgb(value))));
            }
        }
    }
}

TEST(ImageFiles, HdrHoldsLinearValuesToHalfAStepOfItsMantissa) {
    const test::ScratchDirectory scratch;
    // Narrow pictures are written flat, others in runs, and rows longer than a run can be in several.
    for (const std::size_t width : {3U, 8U, 37U, 700U}) {
        for (const double magnitude : {1e-12, 0.7, 255.6, 1e12}) {
            const Image image = some_picture(width, 5, magnitude);
            const std::string file = scratch / "a.hdr";
            write_whole_file(file, radiance_hdr_of(image));
            vtkNew<vtkHDRReader> reader;
            vtkImageData* data = read(*reader, file);
            ASSERT_EQ(data->GetDimensions()[0], static_cast<int>(width));
            ASSERT_EQ(data->GetDimensions()[1], 5);
            for (std::size_t y = 0; y < 5; ++y) {
                for (std::size_t x = 0; x < width; ++x) {
                    const auto& pixel = image.at(x, y);
                    const auto largest = static_cast<double>(std::max({pixel[0], pixel[1], pixel[2]}));
                    for (std::size_t c = 0; c < 3; ++c) {
                        // The largest mantissa is at least 127.5: half a step is 1/255 of the largest channel at most.
                        EXPECT_NEAR(data->GetScalarComponentAsDouble(static_cast<int>(x), static_cast<int>(4 - y), 0,
                                                                     static_cast<int>(c)),
                                    static_cast<double>(pixel[c]), largest / 255.0);
                    }
                }
            }
        }
    }
}

TEST(ImageFiles, WhatHasNoMantissaIsBlack) {
    Image image{1, 1, {{-1.0F, std::nanf(""), 0.0F}}};
    const std::string file = radiance_hdr_of(image);
    EXPECT_EQ(file.substr(file.size() - 4), std::string(4, '\0'));
}

TEST(ImageFiles, TheNameSaysWhichFormat) {
    EXPECT_FALSE(is_radiance_hdr("a.hdr.PNG"));
    EXPECT_TRUE(is_radiance_hdr("a.HDR"));
    EXPECT_THROW(is_radiance_hdr("a.jpg"), UsageError);
    EXPECT_THROW(is_radiance_hdr("hdr"), UsageError);
}

} // namespace
} // namespace difusa::image_files_test
