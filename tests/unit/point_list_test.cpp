#include <difusa/output/point_list.h>

#include <difusa/core/error.h>
#include <difusa/io/field_file.h>

#include <scratch_directory.h>
#include <support/refusal.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace difusa::point_list_test {
namespace {

using test::ScratchDirectory;
using testing::AllOf;
using testing::HasSubstr;

class PointList : public testing::Test {
  protected:
    std::vector<ListedPoint> read(const std::string& text) const {
        write_whole_file(folder_ / "places.csv", text);
        return read_point_list(folder_ / "places.csv");
    }
    std::string refused(const std::string& text) const {
        return test::refusal_of([&] { read(text); }, text);
    }
    ScratchDirectory folder_;
};

TEST_F(PointList, WaysToWriteOne) {
    for (const char* text :
         {"1,-2.5,3e2", "1;-2.5;3e2\r\n", "1 -2.5\t3e2", " 1 , -2.5 ,3e2 # a comment", "# x,y\n\n1,-2.5,3e2#\n",
          "x,y,z\n1,-2.5,3e2", "X Y Z\n1 -2.5 3e2", "\"x\";\"Y\";\"z\"\n1;-2.5;3e2", "\"1\",\"-2.5\",\"3e2\"",
          "\" 1\" , -2.5 , \"3e2 \"", "\xef\xbb\xbfx,y,z\n+1,-2.5,300"}) {
        SCOPED_TRACE(text);
        const std::vector<ListedPoint> points = read(text);
        ASSERT_EQ(points.size(), 1U);
        EXPECT_EQ(points[0].position, Vec3(1.0, -2.5, 300.0));
        EXPECT_FALSE(points[0].normal);
    }
    const std::vector<ListedPoint> points = read("x,y,z,nx,ny,NZ\n1,2,3,0,0,-4\n4,5,6,0,2,0\n");
    ASSERT_EQ(points.size(), 2U);
    EXPECT_EQ(points[0].normal, Vec3(0.0, 0.0, -1.0));
    EXPECT_EQ(points[1].position, Vec3(4.0, 5.0, 6.0));
}

TEST_F(PointList, AnEmptyFieldIsNoCoordinate) {
    EXPECT_THAT(refused("x,y,z\n1,2,3\n1,5,,0\n"), HasSubstr("places.csv:3: field 3 is empty"));
    EXPECT_THAT(refused("1;5; ;0"), HasSubstr("places.csv:1: field 3 is empty"));
    EXPECT_THAT(refused(",1,5,0"), HasSubstr(":1: field 1 is empty"));
    EXPECT_THAT(refused("1,5,0,"), HasSubstr(":1: field 4 is empty"));
    EXPECT_THAT(refused("1,5,0, # end"), HasSubstr(":1: field 4 is empty"));
    EXPECT_THAT(refused("1,\"\",0,3"), HasSubstr(":1: field 2 is empty"));
    EXPECT_THAT(refused("1,2,3\n,,\n"), HasSubstr(":2: field 1 is empty"));
}

TEST_F(PointList, AHeadingNamesTheColumnsInOrder) {
    for (const char* heading : {"y,x,z", "x,z,y", "x,y,z,ny,nx,nz", "nx,ny,nz,x,y,z", "x,y", "x,y,z,w", "name,x,y,z",
                                "place", "x,y,z,nx,ny,nz,u", "0.5m,1,2"}) {
        EXPECT_THAT(refused(std::string(heading) + "\n1,2,3\n"),
                    AllOf(HasSubstr("places.csv:1: "), HasSubstr("x,y,z or x,y,z,nx,ny,nz in this order"),
                          HasSubstr(std::string("'") + heading + "'")));
    }
    EXPECT_THAT(refused("1,2,3\nx,y,z\n"), HasSubstr(":2: expected a coordinate, found 'x'"));
}

TEST_F(PointList, WhatIsNoPlace) {
    EXPECT_THAT(refused("1,2\n"), HasSubstr(":1: a point has 3 coordinates, or 3 and a normal of 3, not 2"));
    EXPECT_THAT(refused("1,2,3,4\n"), HasSubstr("not 4 numbers"));
    EXPECT_THAT(refused("1,2,3,0,0,0\n"), HasSubstr("the normal has length 0"));
    EXPECT_THAT(refused("1,nan,3\n"), HasSubstr("not finite"));
    EXPECT_THAT(refused("1,1.#INF,3\n"), HasSubstr("not finite"));
    EXPECT_THAT(refused("1,2,1e76\n"), HasSubstr("beyond 1e75"));
    EXPECT_THAT(refused("1,2,up\n"), HasSubstr("expected a coordinate, found 'up'"));
    EXPECT_THAT(refused("1,\"2,3\n"), HasSubstr("never closed"));
    EXPECT_THAT(refused("\"1\"2,3,4\n"), HasSubstr("expected a comma, a semicolon or a blank, found '2'"));
    EXPECT_THAT(refused("1,5;2,5;3,5\n"), HasSubstr("both commas and semicolons"));
    EXPECT_THAT(refused("x,y,z\n# nothing\n"), HasSubstr("contains no points"));
}

} // namespace
} // namespace difusa::point_list_test
