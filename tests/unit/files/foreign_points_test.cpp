// Files as others write them, by hand, and damaged ones.
#include <gmock/gmock.h>

#include "common/files/points/point_files.hpp"
#include "common/files/scalar_types.hpp"
#include "lcm_tools/files/little_endian.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/support/lzf.hpp"

namespace marco::files {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::pack_lzf;
using ::marco::testing::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Rgb = std::array<uint8_t, 3>;
using Points = std::vector<Eigen::Vector3f>;

template <class Number>
std::string bytes_of(std::initializer_list<Number> numbers) {
  std::string bytes;
  for (const Number number : numbers) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  return bytes;
}

class ForeignPoints : public ::testing::Test {
 protected:
  PointCloud read(const std::string& name, const std::string& content) const {
    return read_points(folder_.write(name, content));
  }
  std::string said(const std::string& name, const std::string& content) const {
    return complaint([&] { read(name, content); });
  }

 private:
  TemporaryFolder folder_;
};

std::string pcd(const std::string& fields, const std::string& points, const std::string& data) {
  return "# .PCD v.7 - Point Cloud Data file format\nVERSION .7\n" + fields + "\n" + points +
         "\nVIEWPOINT 0 0 0 1 0 0 0\nDATA " + data;
}

constexpr const char* kXyz = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1";

TEST_F(ForeignPoints, PcdTextOfRowsWithAPose) {
  const PointCloud cloud =
      read("a.pcd",
           "VERSION 0.7\r\nFIELDS x y z rgb i\r\nSIZE 4 4 4 4 4\r\nTYPE F F F F F\r\nWIDTH 1\r\n"
           "HEIGHT 2\r\nVIEWPOINT 1 2 3 0 0 0 1\r\nPOINTS 2\r\nDATA ascii\r\n"
           "1 -2 +3.5 2.3418052e-38 7\r\nnan nan nan 0 nan\r\n");
  ASSERT_EQ(cloud.points_m.size(), 2U);
  EXPECT_EQ(cloud.points_m[0], Eigen::Vector3f(1, -2, 3.5F));
  EXPECT_FALSE(cloud.points_m[1].allFinite());
  EXPECT_EQ(cloud.rows, 2U);
  EXPECT_EQ(cloud.colors_rgb[0], (Rgb{255, 0, 0}));
  EXPECT_EQ(cloud.intensities[0], 7.0F);
  ASSERT_TRUE(cloud.world_from_scanner.has_value());
  EXPECT_TRUE(cloud.world_from_scanner->isApprox(make_pose3({1, 2, 3}, 0, 0, M_PI), 1e-12));
}

// Doubles behind padding, a colour in four bytes, an alpha above it.
TEST_F(ForeignPoints, PcdBinaryWithPaddingAndDoubles) {
  const std::string body = bytes_of<uint8_t>({9, 9, 9}) + bytes_of({1.5, 2.5, -3.5}) +
                           bytes_of({0xff0a141eU}) + bytes_of<uint16_t>({40000});
  const PointCloud cloud = read("a.pcd", pcd("FIELDS _ x y z rgba reflectivity\nSIZE 1 8 8 8 4 2\n"
                                             "TYPE U F F F U U\nCOUNT 3 1 1 1 1 1",
                                             "WIDTH 1\nHEIGHT 1\nPOINTS 1", "binary\n") +
                                             body);
  EXPECT_EQ(cloud.points_m, (Points{{1.5F, 2.5F, -3.5F}}));
  EXPECT_THAT(cloud.colors_rgb, ElementsAre(Rgb{10, 20, 30}));
  EXPECT_THAT(cloud.intensities, ElementsAre(40000.0F));
  EXPECT_EQ(cloud.rows, 0U);
  EXPECT_FALSE(cloud.world_from_scanner.has_value());
}

TEST_F(ForeignPoints, PcdCompressedLiesFieldByField) {
  std::string fields;
  for (const int axis : {0, 1, 2}) {
    for (int i = 0; i < 1000; ++i) fields += bytes_of({static_cast<float>(axis * i % 50)});
  }
  const std::string packed = pack_lzf(fields);
  EXPECT_LT(packed.size(), fields.size() / 10);
  const auto whole = [&](std::size_t size, std::size_t of) {
    return pcd(kXyz, "WIDTH 1000\nHEIGHT 1\nPOINTS 1000", "binary_compressed\n") +
           bytes_of({static_cast<uint32_t>(size), static_cast<uint32_t>(of)}) + packed;
  };
  const PointCloud cloud = read("a.pcd", whole(packed.size(), fields.size()));
  ASSERT_EQ(cloud.points_m.size(), 1000U);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(cloud.points_m[static_cast<std::size_t>(i)],
              Eigen::Vector3f(0, static_cast<float>(i % 50), static_cast<float>(2 * i % 50)));
  }
  EXPECT_THAT(said("a.pcd", whole(packed.size() + 1, fields.size())), HasSubstr("ends inside"));
  EXPECT_THAT(said("a.pcd", whole(packed.size(), fields.size() + 12)),
              HasSubstr("does not agree with its compressed points"));
  EXPECT_THAT(said("a.pcd", whole(packed.size() - 1, fields.size())), HasSubstr("damaged"));
}

TEST_F(ForeignPoints, PcdThatLiesIsRefused) {
  const auto of = [&](const std::string& points, const std::string& data) {
    return said("a.pcd", pcd(kXyz, points, data));
  };
  const std::string more = "a.pcd: its header declares more points than the file contains";
  EXPECT_THAT(of("WIDTH 1000000000000\nHEIGHT 1\nPOINTS 1000000000000", "binary\n1234"),
              HasSubstr(more));
  EXPECT_THAT(of("WIDTH 1000000000000\nHEIGHT 1\nPOINTS 1000000000000", "ascii\n1 2 3"),
              HasSubstr(more));
  EXPECT_THAT(of("WIDTH 9999999999999\nHEIGHT 9999999999999", "ascii\n1 2 3"), HasSubstr(more));
  const std::string packed_points = bytes_of({12U, 4294967292U}) + std::string(12, 'x');
  EXPECT_THAT(of("WIDTH 357913941\nHEIGHT 1", "binary_compressed\n" + packed_points),
              HasSubstr("damaged"));
  // A copy of what came before the beginning.
  EXPECT_THAT(of("WIDTH 1\nHEIGHT 1", "binary_compressed\n" + bytes_of({3U, 12U}) + "\xe0\x03\x05"),
              HasSubstr("damaged"));
  EXPECT_THAT(of("WIDTH nan\nHEIGHT 1", "ascii\n1 2 3"), HasSubstr("WIDTH is not a number"));
  EXPECT_THAT(of("WIDTH 2\nHEIGHT 1\nPOINTS 3", "ascii\n1 2 3"), HasSubstr("WIDTH times HEIGHT"));
  EXPECT_THAT(of("WIDTH 2\nHEIGHT 1", "ascii\n1 2 3.00001\n4 5\n"),
              HasSubstr("DATA):2: expected 3"));
  EXPECT_THAT(of("WIDTH 2\nHEIGHT 1", "ascii\n1.00 2.00 3.00\n"), HasSubstr("ends before"));
  EXPECT_THAT(of("WIDTH 1\nHEIGHT 1", "hex\n1 2 3"), HasSubstr("DATA is none of"));
  EXPECT_THAT(said("a.pcd", pcd("FIELDS x y\nSIZE 4 4\nTYPE F F", "WIDTH 0", "ascii\n")),
              HasSubstr("no x, y, z"));
  EXPECT_THAT(said("a.pcd", pcd("FIELDS x\nSIZE 3\nTYPE F", "WIDTH 0", "ascii\n")),
              HasSubstr("TYPE F and SIZE 3"));
  EXPECT_THAT(said("a.pcd", "VERSION .7\nFIELDS x y z\n"), HasSubstr("no DATA"));
}

TEST_F(ForeignPoints, PlyOfAnyPropertiesInAnyOrder) {
  std::string body;
  const auto put_big = [&](auto number) {
    const std::string little = bytes_of({number});
    body.append(little.rbegin(), little.rend());
  };
  put_big(uint16_t{65535}), put_big(uint16_t{0}), put_big(uint16_t{32896});
  put_big(-2.5), put_big(1.5F), put_big(int32_t{-7}), put_big(int8_t{-3});
  const PointCloud cloud =
      read("a.ply",
           "ply\r\nformat binary_big_endian 1.0\r\ncomment element vertex 9\r\nobj_info none\r\n"
           "element vertex 1\r\nproperty ushort red\r\nproperty ushort green\r\n"
           "property ushort blue\r\nproperty double z\r\nproperty float y\r\n"
           "property int32 x\r\nproperty int8 scalar_Intensity\r\nend_header\r\n" +
               body);
  EXPECT_EQ(cloud.points_m, (Points{{-7, 1.5F, -2.5F}}));
  EXPECT_THAT(cloud.colors_rgb, ElementsAre(Rgb{255, 0, 128}));
  EXPECT_THAT(cloud.intensities, ElementsAre(-3.0F));
}

TEST_F(ForeignPoints, PlyThatLiesIsRefused) {
  const std::string head = "ply\nformat ascii 1.0\nelement vertex ";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_THAT(said("a.ply", head + "1000000000000\n" + xyz + "end_header\n1 2 3\n"),
              HasSubstr("a.ply: its header declares 1000000000000 of 'vertex', more than"));
  EXPECT_THAT(said("a.ply", head + "nan\n" + xyz + "end_header\n1 2 3\n"),
              HasSubstr("'element vertex nan' has no number"));
  EXPECT_THAT(said("a.ply", head + "1\n" + xyz + "end_header\n1 2 x\n"), HasSubstr("no number"));
  EXPECT_THAT(said("a.ply", head + "1\n" + xyz + "end_header\n1 23456 \n"),
              HasSubstr("ends before"));
  EXPECT_THAT(
      said("a.ply", head + "1\nproperty list uchar float a\n" + xyz + "end_header\n99 1 2 3"),
      HasSubstr("a list is longer than the file"));
  EXPECT_THAT(said("a.ply", head + "1\nproperty quad x\nend_header\n"),
              HasSubstr("is not a property"));
  EXPECT_THAT(said("a.ply", head + "1\nproperty float x\nend_header\n1\n"),
              HasSubstr("no x, y, z"));
  EXPECT_THAT(said("a.ply", "ply\nformat ascii 1.0\nend_header\n"), HasSubstr("no vertices"));
  EXPECT_THAT(said("a.ply", "ply\nformat middle 1.0\nend_header\n"),
              HasSubstr("its format is none"));
  EXPECT_THAT(said("a.ply", head + "1\n"), HasSubstr("header has no end"));
}

TEST_F(ForeignPoints, TextByTheNumberOfItsColumns) {
  EXPECT_EQ(read("a.xyz", "# made by\n\n1 2 3\n// two\n4\t5\t6\r\n").points_m,
            (Points{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_THAT(read("a.asc", "1;2;3;-0.25").intensities, ElementsAre(-0.25F));
  EXPECT_THAT(read("a.txt", "1 2 3 10 20 30\n").colors_rgb, ElementsAre(Rgb{10, 20, 30}));
  const PointCloud both = read("a.txt", "1 2 3 5 10 20 30 label\n1 2 3 6 0 0 255 none\n");
  EXPECT_THAT(both.intensities, ElementsAre(5.0F, 6.0F));
  EXPECT_THAT(both.colors_rgb, ElementsAre(Rgb{10, 20, 30}, Rgb{0, 0, 255}));
  // Colours of 0..1, and normals, which are none.
  EXPECT_THAT(read("a.txt", "1 2 3 0 0 0\n1 2 3 0.5 1 0\n").colors_rgb,
              ElementsAre(Rgb{0, 0, 0}, Rgb{128, 255, 0}));
  EXPECT_THAT(read("a.txt", "1 2 3 0 -0.6 0.8\n").colors_rgb, ElementsAre());
  // The names say more than the number of columns.
  const PointCloud named = read("a.csv", "\"Intensity\",\"Z\",\"Y\",\"X\"\n0.5,3,2,1\n");
  EXPECT_EQ(named.points_m, (Points{{1, 2, 3}}));
  EXPECT_THAT(named.intensities, ElementsAre(0.5F));
  EXPECT_EQ(read("a.csv", "east,north,up\n1,2,3\n").points_m, (Points{{1, 2, 3}}));
  EXPECT_THAT(said("a.xyz", "1 2 3 4\n# so\n1 2 3\n"),
              HasSubstr("a.xyz:3: expected 4 numbers, found 3"));
  EXPECT_THAT(said("a.xyz", "1 2 3\n1 2 1e999\n"),
              HasSubstr("a.xyz:2: expected 3 numbers, found 2"));
}

TEST_F(ForeignPoints, PtsOfTwoBlocks) {
  const PointCloud cloud =
      read("a.pts", "2\r\n1 2 3 -2048 1 2 3\r\n4 5 6 2047 4 5 6\r\n1\r\n7 8 9 0 7 8 9\r\n");
  EXPECT_EQ(cloud.points_m, (Points{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}));
  EXPECT_THAT(cloud.intensities, ElementsAre(-2048.0F, 2047.0F, 0.0F));
  EXPECT_EQ(cloud.colors_rgb[2], (Rgb{7, 8, 9}));
  EXPECT_THAT(said("a.pts", "1000000000000\n1 2 3\n"), HasSubstr("a.pts:1: declares more points"));
  EXPECT_THAT(said("a.pts", "2\n1.000 2.000 3.000\n"), HasSubstr("before the last of 2 points"));
  EXPECT_THAT(said("a.pts", "1\n1 2 3\n4 5 6\n"),
              HasSubstr("a.pts:3: expected a number of points"));
}

std::string ptx(const std::string& columns, const std::string& rows, const std::string& matrix) {
  return columns + "\n" + rows + "\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n" + matrix;
}

TEST_F(ForeignPoints, PtxOfColumnsWithAPose) {
  const std::string turned = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n558312.25 5240857.5 76 1\n";
  const std::string points = "1 2 3 0.25\n0 0 0 0.5\n4 5 6 0.75\n7 8 9 1\n";
  const PointCloud cloud = read("a.ptx", ptx("2", "2", turned) + points);
  ASSERT_EQ(cloud.points_m.size(), 4U);
  EXPECT_EQ(cloud.rows, 2U);
  EXPECT_FALSE(cloud.points_m[1].allFinite());
  EXPECT_TRUE(cloud.world_from_scanner->isApprox(
      make_pose3({558312.25, 5240857.5, 76}, 0, 0, M_PI / 2), 1e-12));
  EXPECT_THAT(cloud.intensities, ElementsAre(0.25F, 0.5F, 0.75F, 1.0F));
  EXPECT_THAT(said("a.ptx", ptx("60", "60", turned) + points), HasSubstr("more points"));
  EXPECT_THAT(said("a.ptx", ptx("2", "nan", turned) + points), HasSubstr("more points"));
  EXPECT_THAT(said("a.ptx", ptx("1", "5", turned) + points), HasSubstr("before its last point"));
  EXPECT_THAT(said("a.ptx", ptx("1", "3", turned) + points), HasSubstr("a second scan begins"));
  EXPECT_THAT(said("a.ptx", ptx("2", "2", "2 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n") + points),
              HasSubstr("not a rotation"));
}

TEST_F(ForeignPoints, UosIsTurnedAndScaled) {
  const PointCloud cloud = read("a.3d", "2 1\n100 200 300 17\n-100 0 50 18\n");
  EXPECT_TRUE(cloud.points_m.at(0).isApprox(Eigen::Vector3f(3, -1, 2)));
  EXPECT_TRUE(cloud.points_m.at(1).isApprox(Eigen::Vector3f(0.5F, 1, 0)));
  EXPECT_THAT(cloud.intensities, ElementsAre(17.0F, 18.0F));
}

TEST_F(ForeignPoints, OtherFilesAreNone) {
  const TemporaryFolder folder;
  const auto format = [&](const char* name, const char* content) {
    return point_format_of(folder.write(name, content));
  };
  EXPECT_EQ(format("a.txt", "FLASER 3 1 2 3\nFLASER 3 1 2 3\n"), std::nullopt);
  EXPECT_EQ(format("a.txt", "1 2\n3 4\n"), std::nullopt);
  EXPECT_EQ(format("a.csv", ""), std::nullopt);
  EXPECT_EQ(format("a.log", "1 2 3\n"), std::nullopt);
  EXPECT_EQ(format("a.xyz", "3\nwater\nO 0 0 0\n"), std::nullopt);
  EXPECT_EQ(format("a.3d", "x"), std::nullopt);
  EXPECT_EQ(format("without_ending", "FIELDS x y z\n"), PointFormat::pcd);
  EXPECT_EQ(format("a.TXT", "3\n1 2 3\n"), PointFormat::pts);
  EXPECT_EQ(point_format_of(folder.path()), std::nullopt);
  EXPECT_EQ(point_format_of("/nonexistent/a.ply"), std::nullopt);
  EXPECT_THAT(said("a.log", "1 2 3\n"), HasSubstr("a.log: not a point file"));
  EXPECT_THAT(complaint([] { read_points("/nonexistent/a.ply"); }),
              HasSubstr("/nonexistent/a.ply"));
}

}  // namespace
}  // namespace marco::files
