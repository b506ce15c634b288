// What we write is read back, of others' files all kinds of corners; broken lines are named.
#include <gmock/gmock.h>

#include "common/files/mesh_file.hpp"
#include "common/files/obj.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/support/matchers.hpp"

namespace marco::files {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Triangle = std::array<uint32_t, 3>;

TEST(ObjReader, ReadsWhatIsWritten) {
  const TemporaryFolder folder;
  TriangleMesh mesh;
  mesh.vertices_m = {{0, 0, 0}, {2, 0, -1.5F}, {0, 3, 0}, {0.5F, 0.5F, 1.25F}};
  mesh.normals = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.colors_rgb = {{255, 0, 0}, {0, 254, 0}, {1, 0, 255}, {51, 102, 204}};
  mesh.triangles = {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  write_obj(folder.path() / "m.obj", mesh);
  const TriangleMesh back = read_mesh(folder.path() / "m.obj");
  EXPECT_EQ(back.vertices_m, mesh.vertices_m);
  EXPECT_EQ(back.normals, mesh.normals);
  EXPECT_EQ(back.colors_rgb, mesh.colors_rgb);
  EXPECT_EQ(back.triangles, mesh.triangles);
  write_obj(folder.path() / "none.obj", TriangleMesh{});
  EXPECT_TRUE(read_mesh(folder.path() / "none.obj").triangles.empty());
}

TEST(ObjReader, ReadsAllKindsOfCornersAndPolygonsAsFans) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = read_obj(folder.write("m.obj",
                                                  "# five corners\r\nmtllib a.mtl\r\no thing\r\n"
                                                  "v 0 0 0\r\nv 1 0 0\nv 1 1 0 1.0\nv 0.5 2 0\n"
                                                  "v 0 1 0 # the last\nvt 0 0\nvn 0 0 2\n"
                                                  "f 1 2/1 3//1 4/1/1 5\nf -5 -4 -3\n"));
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{0, 3, 4},
                                          Triangle{0, 1, 2}));
  EXPECT_EQ(mesh.vertices_m[3], Eigen::Vector3f(0.5F, 2, 0));
  // Only two of the vertices have a normal.
  EXPECT_TRUE(mesh.normals.empty());
  EXPECT_TRUE(mesh.colors_rgb.empty());
}

TEST(ObjReader, AVertexOfSeveralNormalsGetsTheirMean) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = read_obj(
      folder.write("m.obj",
                   "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvn 0 1 0\nf 1//1 2//1 3//1\n"
                   "f 1//2 4//2 2//2\n"));
  ASSERT_EQ(mesh.normals.size(), 4U);
  EXPECT_LT((mesh.normals[0] - Eigen::Vector3f(0, 0.70711F, 0.70711F)).norm(), 1e-4F);
  EXPECT_EQ(mesh.normals[2], Eigen::Vector3f(0, 0, 1));
  EXPECT_EQ(mesh.normals[3], Eigen::Vector3f(0, 1, 0));
}

TEST(ObjReader, BrokenLinesAreNamed) {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& text) {
    return complaint([&] { read_obj(folder.write("m.obj", text)); });
  };
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_THAT(said(three + "f 1 2 4\n"), HasSubstr("m.obj:4: '4' is not one of the 3 vertices"));
  EXPECT_THAT(said(three + "f 1 2 0\n"), HasSubstr("m.obj:4: '0'"));
  EXPECT_THAT(said(three + "f 1 2 -4\n"), HasSubstr("m.obj:4: '-4'"));
  EXPECT_THAT(said(three + "f 1 2 9223372036854775808\n"), HasSubstr("m.obj:4: '9223"));
  EXPECT_THAT(said(three + "f 1//1 2//1 3//1\n"), HasSubstr("not one of the 0 normals"));
  EXPECT_THAT(said(three + "f 1/ 2 x/1\n"), HasSubstr("m.obj:4: 'x' is not one"));
  EXPECT_THAT(said(three + "\nf 1 2\n"), HasSubstr("m.obj:5: a face has at least three"));
  EXPECT_THAT(said("v 0 0\n"), HasSubstr("m.obj:1: a vertex has x y z"));
  EXPECT_THAT(said("v 0 0 nan\n"), HasSubstr("'nan' is not a finite number"));
  EXPECT_THAT(said("v 0 0 1e39\n"), HasSubstr("'1e39' is not a finite number"));
  EXPECT_THAT(said("v 0 0 0 0 0 2\n"), HasSubstr("are 0 to 1"));
  EXPECT_THAT(said("v 0 0 0 0 0 0 0\n"), HasSubstr("at most"));
  EXPECT_THAT(said("ply\nformat\n"), HasSubstr("m.obj:1: 'ply' is not a supported OBJ line"));
  EXPECT_THAT(complaint([&] { read_obj(folder.path() / "no.obj"); }), HasSubstr("no.obj"));
  EXPECT_THAT(complaint([&] { read_obj(folder.path()); }), HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace marco::files
