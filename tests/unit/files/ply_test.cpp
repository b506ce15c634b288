// Meshes as others write them.
#include <gmock/gmock.h>

#include "common/files/ply.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::files {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Triangle = std::array<uint32_t, 3>;

constexpr const char* kSquare =
    "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nelement camera 1\r\nproperty float f\r\n"
    "property list uchar int ids\r\nelement vertex 4\r\nproperty float nz\r\nproperty double y\r\n"
    "property double x\r\nproperty int z\r\nproperty float nx\r\nproperty float ny\r\n"
    "property float diffuse_red\r\nproperty float diffuse_green\r\nproperty float diffuse_blue\r\n"
    "element face 3\r\nproperty uchar flags\r\nproperty list uchar int vertex_index\r\n"
    "property list int float texcoord\r\nend_header\r\n";
constexpr const char* kCorners =
    "0.5 2 7 8\r\n1 0 0 0 0 0 1 0 0\r\n1 0 1 0 0 0 0 0.5 0\r\n1 1 1 0 0 0 0 0 1\r\n"
    "1 1 0 2 0 0 0 0 0\r\n";

TEST(Ply, TextOfPolygonsAndPropertiesInAnyOrder) {
  const TemporaryFolder folder;
  const TriangleMesh mesh =
      read_ply(folder.write("a.ply", std::string(kSquare) + kCorners +
                                         "1 4 0 1 2 3 2 0.5 0.5\r\n0 3 2 1 0 0\r\n0 2 0 1 0"));
  EXPECT_THAT(mesh.vertices_m, ElementsAre(Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 0, 0),
                                           Eigen::Vector3f(1, 1, 0), Eigen::Vector3f(0, 1, 2)));
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{2, 1, 0}));
  EXPECT_THAT(mesh.normals, ::testing::Each(Eigen::Vector3f(0, 0, 1)));
  EXPECT_EQ(mesh.colors_rgb[1], (std::array<uint8_t, 3>{0, 128, 0}));
}

TEST(Ply, BigEndianTriangles) {
  const TemporaryFolder folder;
  const std::string big(
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty short x\nproperty short y\n"
      "property short z\nelement face 1\nproperty list ushort uchar vertex_indices\nend_header\n");
  const std::string body("\0\0\0\1\1\0\0\2\0\3\xff\xff\0\4\0\5\0\6\0\3\0\1\2", 23);
  const TriangleMesh mesh = read_ply(folder.write("a.ply", big + body));
  EXPECT_EQ(mesh.vertices_m[0], Eigen::Vector3f(0, 1, 256));
  EXPECT_EQ(mesh.vertices_m[1], Eigen::Vector3f(2, 3, -1));
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
}

TEST(Ply, DamageIsNamed) {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& faces) {
    return complaint(
        [&] { read_ply(folder.write("a.ply", std::string(kSquare) + kCorners + faces)); });
  };
  EXPECT_THAT(said("1 3 0 1 4 0 1 3 0 1 2 0 1 3 0 1 2 0"),
              HasSubstr("a vertex that does not exist"));
  EXPECT_THAT(said("1 3 0 1 -1 0 1 3 0 1 2 0 1 3 0 1 2 0"), HasSubstr("does not exist"));
  EXPECT_THAT(said("1 200 0 1 2 0 1 3 0 1 2 0"), HasSubstr("a list is longer than the file"));
  EXPECT_THAT(said("1 3 0 1 2 -1 1 3 0 1 2 0 1 3"), HasSubstr("a list is longer than the file"));
  EXPECT_THAT(said("1 3 0 1 2 0 1 3 0 1 2 0 1 3 0 1"), HasSubstr("ends before its last element"));
}

}  // namespace
}  // namespace marco::files
