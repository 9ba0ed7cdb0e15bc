// Daylight coefficients in Radiance's format: written, read back, refused.
#include <difusa/core/error.h>
#include <difusa/output/daylight_files.h>

#include <scratch_directory.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

namespace difusa::daylight_files_test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
using testing::ThrowsMessage;

std::string content_of(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

DaylightMatrix made_up(int channels) {
    DaylightMatrix matrix{SkyDivision(1, Vec3::UnitY(), -Vec3::UnitZ()), std::vector<SurfacePoint>(2), {}};
    matrix.coefficients.channels = channels;
    matrix.coefficients.value.resize(2, 146 * channels);
    for (Eigen::Index k = 0; k < matrix.coefficients.value.size(); ++k) {
        matrix.coefficients.value.data()[k] = k % 5 == 0 ? 0.0 : 1.0 / static_cast<double>(k + 3);
    }
    return matrix;
}

TEST(DaylightFiles, AreReadBack) {
    const test::ScratchDirectory scratch;
    for (const int channels : {1, 3}) {
        const DaylightMatrix matrix = made_up(channels);
        write_daylight(matrix, true, scratch / "c.mtx");
        const std::string text = content_of(scratch / "c.mtx");
        EXPECT_THAT(text, StartsWith("#?RADIANCE\n"));
        EXPECT_THAT(text, HasSubstr("\nNROWS=2\nNCOLS=146\nNCOMP=3\nFORMAT=ascii\n\n0 "));
        const DaylightTable table = read_daylight(scratch / "c.mtx");
        EXPECT_EQ(table.sky.factor(), 1);
        EXPECT_EQ(table.sky.up(), Vec3::UnitY());
        EXPECT_EQ(table.sky.north(), -Vec3::UnitZ());
        const Values radiance = Values::Random(146, 3).cwiseAbs();
        // Eight digits were written.
        EXPECT_LE((table.coefficients.irradiance(radiance) - matrix.coefficients.irradiance(radiance)).norm(),
                  1e-7 * matrix.coefficients.irradiance(radiance).norm());
        write_daylight(matrix, true, scratch / "c.npz");
        EXPECT_GT(content_of(scratch / "c.npz").size(), 4U * 2U * 146U * 8U);
    }
    EXPECT_THROW(write_daylight(made_up(1), false, scratch / "c.csv"), UsageError);
}

TEST(DaylightFiles, OfOtherProgramsNeedNoDirections) {
    const test::ScratchDirectory scratch;
    std::ofstream file(scratch / "r.mtx");
    file << "#?RADIANCE\nrcontrib -I+ ...\nNCOMP=3\nNROWS=1\nNCOLS=146\nFORMAT=ascii\n\n";
    for (int k = 0; k < 146; ++k) {
        file << "1.0e0 2.000000e+00 3\t";
    }
    file << "\n";
    file.close();
    const DaylightTable table = read_daylight(scratch / "r.mtx");
    EXPECT_EQ(table.sky.up(), Vec3::UnitZ());
    EXPECT_EQ(table.coefficients.irradiance(Values::Ones(146, 3)).row(0), Eigen::RowVector3d(146, 292, 438));
}

TEST(DaylightFiles, AreRefusedIfTheyAreNoMatrix) {
    const test::ScratchDirectory scratch;
    write_daylight(made_up(1), false, scratch / "good.mtx");
    const std::string good = content_of(scratch / "good.mtx");
    const auto refused = [&](const std::string& text, const std::string& why) {
        std::ofstream(scratch / "bad.mtx", std::ios::binary) << text;
        EXPECT_THAT([&] { read_daylight(scratch / "bad.mtx"); }, ThrowsMessage<InputError>(HasSubstr(why))) << why;
    };
    const auto changed = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        return text.replace(text.find(from), from.size(), to);
    };
    refused("", "is empty");
    refused("1 2 3\n", "#?RADIANCE");
    refused("#?RADIANCE\nNROWS=1\n", "ends within its header");
    refused(changed("FORMAT=ascii", "FORMAT=float"), "FORMAT=ascii");
    refused(changed("NCOMP=3", "NCOMP=1"), "NCOMP=3");
    refused(changed("NCOLS=146", "NCOLS=145"), "146, 578");
    refused(changed("NROWS=2", "NROWS=0"), "at least 1");
    refused(changed("NROWS=2", "NROWS=1"), "more numbers");
    refused(changed("NROWS=2", "NROWS=1000000000"), "too short");
    refused(good.substr(0, good.size() - 20), "a coefficient");
    refused(changed("\n\n0 ", "\n\ninf "), "finite");
    refused(changed("\n\n0 ", "\n\nx "), "coefficient");
    refused(changed("SKY_NORTH= 0 0 -1", "SKY_NORTH= 0 0 0"), "directions");
}

TEST(DaylightFiles, TablesHavePlacesWhereTheyAreKnown) {
    const Values H = Values::Constant(1, 3, 2.0);
    EXPECT_EQ(daylight_table(H, {}), "point,x,y,z,nx,ny,nz,irradiance_r,irradiance_g,irradiance_b,illuminance\n"
                                     "0,,,,,,,2,2,2,1366\n");
    EXPECT_THAT(daylight_table(H, {SurfacePoint{Vec3(1, 2, 3), Vec3::UnitZ(), none, 0, 0}}),
                HasSubstr("\n0,1,2,3,0,0,1,2,2,2,1366\n"));
}

} // namespace
} // namespace difusa::daylight_files_test
