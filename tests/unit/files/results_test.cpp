// What `map` writes comes back the same, and broken files are refused by name.
#include <gmock/gmock.h>

#include "common/files/map_yaml.hpp"
#include "common/files/ply.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/support/matchers.hpp"

namespace marco::files {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;

TEST(Tum, PosesAndMicrosecondsSurvive) {
  const TemporaryFolder folder;
  const Trajectory written = {{Utime::from_us(1700000000123457), {1.25, -2.5, 3.0}},
                              {Utime::from_us(1700000000123458), {0, 0, -3.0}},
                              {Utime::from_us(-250000), {0, 0, 0.5}},
                              {Utime::from_us(-1500000), {0, 0, -0.5}}};
  write_tum(folder.path() / "t.tum", written);
  const Trajectory read = read_tum(folder.path() / "t.tum");
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].utime, written[i].utime);
    EXPECT_THAT(read[i].world_from_robot, IsNear(written[i].world_from_robot, 1e-6, 1e-8));
  }
  // As TUM's own tools have it: x y z, then the quaternion x y z w.
  EXPECT_THAT(read_whole_file(folder.path() / "t.tum"),
              HasSubstr("\n-0.250000 0.000000 0.000000 0 0 0 0.247403959 0.968912422\n"));
}

TEST(Tum, ReadsFourColumnsTooAndNamesTheBadLine) {
  const TemporaryFolder folder;
  const auto good = folder.write("g", "# t x y theta\n1.5 1 2 0.5\n");
  EXPECT_THAT(read_tum(good).at(0).world_from_robot, IsNear(Pose2{1, 2, 0.5}, 1e-12, 1e-12));
  const auto bad = folder.write("b", "1.5 1 2 0.5\n2.5 1 x 0.5\n");
  EXPECT_THAT(complaint([&] { read_tum(bad); }), HasSubstr("b:2: 'x' is not a finite number"));
}

TEST(Tum, ValuesThatAreNotFiniteAreRefused) {
  const TemporaryFolder folder;
  const auto four = folder.write("four", "1.5 1 nan 0.5\n");
  EXPECT_THAT(complaint([&] { read_tum(four); }), HasSubstr("four:1: 'nan' is not a finite"));
  const auto eight = folder.write("eight", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 inf\n");
  EXPECT_THAT(complaint([&] { read_tum(eight); }), HasSubstr("eight:2: 'inf' is not a finite"));
}

// Every percent has a grey of its own, and none that of the unknown.
TEST(MapYaml, EveryPercentAndTheUnknownSurvive) {
  const TemporaryFolder folder;
  GridMap map;
  map.origin_m = {-1.5, 2.25};
  map.resolution_m = 0.1;
  map.width_cells = 51;
  map.height_cells = 2;
  for (uint8_t percent = 0; percent <= 100; ++percent) map.occupancy.push_back(percent);
  map.occupancy.push_back(GridMap::kUnknown);
  write_map(folder.path(), map);
  const GridMap read = read_map(folder.path() / "map.yaml");
  EXPECT_EQ(read.width_cells, 51);
  EXPECT_EQ(read.height_cells, 2);
  EXPECT_NEAR((read.origin_m - map.origin_m).norm(), 0.0, 1e-9);
  EXPECT_NEAR(read.resolution_m, 0.1, 1e-9);
  EXPECT_EQ(read.occupancy, map.occupancy);
}

TEST(MapYaml, FirstRowOfThePictureIsTheLargestY) {
  const TemporaryFolder folder;
  GridMap map;
  map.width_cells = 1;
  map.height_cells = 2;
  map.occupancy = {0, 100};  // y = 1 is occupied
  write_map(folder.path(), map);
  const std::string pgm = read_whole_file(folder.path() / "map.pgm");
  EXPECT_EQ(static_cast<unsigned char>(pgm[pgm.size() - 2]), 0);  // occupied, on top
  EXPECT_EQ(static_cast<unsigned char>(pgm[pgm.size() - 1]), 254);
}

TEST(MapYaml, RefusesAPictureThatIsTooShort) {
  const TemporaryFolder folder;
  folder.write("map.pgm", "P5\n100 100\n255\nabc");
  const auto yaml = folder.write("map.yaml",
                                 "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
                                 "occupied_thresh: 0.65\nfree_thresh: 0.25\n");
  EXPECT_THAT(complaint([&] { read_map(yaml); }), HasSubstr("map.pgm"));
}

// Sparse files: no room is made for what their headers claim.
TEST(MapYaml, RefusesPicturesByTheirHeaders) {
  const TemporaryFolder folder;
  const auto yaml =
      folder.write("map.yaml", "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n");
  const auto refusal_of = [&](const std::string& head, uint64_t size) {
    std::filesystem::resize_file(folder.write("map.pgm", head), size);
    return complaint([&] { read_map(yaml); });
  };
  EXPECT_THAT(refusal_of("P5\n60000 60000\n255\n", 4'000'000'000), HasSubstr("2^30 cells"));
  EXPECT_THAT(refusal_of("P5\n2000000000 2000000000\n255\n", 100), HasSubstr("2^30 cells"));
  EXPECT_THAT(refusal_of("P5\n30000 30000\n255\n", 800'000'000), HasSubstr("ends early"));
  EXPECT_THAT(refusal_of("P6\n10 10\n255\n", 10'000'000'000), HasSubstr("binary PGM"));
  EXPECT_THAT(refusal_of("P5\n-10 -10\n255\n", 1000), HasSubstr("binary PGM"));
}

TEST(MapYaml, APictureOutsideItsFolderIsRefused) {
  const TemporaryFolder folder;
  for (const char* picture : {"/etc/hostname", "../map.pgm", "a/../../map.pgm"}) {
    const auto yaml = folder.write(
        "map.yaml", std::string("image: ") + picture + "\nresolution: 0.05\norigin: [0, 0, 0]\n");
    EXPECT_THAT(complaint([&] { read_map(yaml); }), HasSubstr("outside its folder")) << picture;
  }
}

TriangleMesh square() {
  TriangleMesh mesh;
  mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5F}, {0, 1, 0}};
  mesh.normals.assign(4, {0, 0, 1});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(Ply, MeshSurvivesBitForBit) {
  const TemporaryFolder folder;
  TriangleMesh mesh = square();
  mesh.colors_rgb.assign(4, {10, 20, 30});
  write_ply(folder.path() / "m.ply", mesh);
  const TriangleMesh read = read_ply(folder.path() / "m.ply");
  EXPECT_EQ(read.vertices_m, mesh.vertices_m);
  EXPECT_EQ(read.normals, mesh.normals);
  EXPECT_EQ(read.colors_rgb, mesh.colors_rgb);
  EXPECT_EQ(read.triangles, mesh.triangles);
}

TEST(Ply, RefusesWhatIsCutOrPointsBeyondItsVertices) {
  const TemporaryFolder folder;
  write_ply(folder.path() / "m.ply", square());
  const std::string whole = read_whole_file(folder.path() / "m.ply");
  const auto cut = folder.write("cut.ply", whole.substr(0, whole.size() - 5));
  EXPECT_THAT(complaint([&] { read_ply(cut); }), HasSubstr("cut.ply"));
  std::string wild = whole;
  wild[wild.size() - 1] = 0x7f;  // last index of the last triangle, little endian: its top byte
  EXPECT_NE(complaint([&] { read_ply(folder.write("wild.ply", wild)); }), "");
  EXPECT_NE(complaint([&] { read_ply(folder.write("text", "hello")); }), "");
}

TEST(Results, APlaceThatCannotBeWrittenIsNamed) {
  const std::filesystem::path path = "/nonexistent/m.ply";
  EXPECT_THAT(complaint([&] { write_ply(path, square()); }), HasSubstr("/nonexistent/m.ply"));
  EXPECT_THAT(complaint([&] { write_tum(path, {}); }), HasSubstr("/nonexistent/m.ply"));
}

}  // namespace
}  // namespace marco::files
