// Compressed GLBs: read back within what they promise, smaller, and damaged ones refused.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "common/files/glb.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::files {
namespace {

using testing::TemporaryFolder;

constexpr float kHalfStepM = 0.5e-3F;

// A wavy sheet of n x n vertices, 100 m from the origin, each of its own colour.
TriangleMesh sheet(uint32_t n) {
  TriangleMesh mesh;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> noise(-0.003F, 0.003F);
  for (uint32_t y = 0; y < n; ++y) {
    for (uint32_t x = 0; x < n; ++x) {
      const float u = 0.05F * static_cast<float>(x), v = 0.05F * static_cast<float>(y);
      mesh.vertices_m.emplace_back(100.0F + u, v, std::sin(u) + noise(random));
      mesh.normals.push_back(Eigen::Vector3f(-std::cos(u), noise(random), 1).normalized());
      mesh.colors_rgb.push_back(
          {static_cast<uint8_t>(x), static_cast<uint8_t>(y), static_cast<uint8_t>(x + y)});
      if (x == 0 || y == 0) continue;
      const uint32_t i = y * n + x;
      mesh.triangles.push_back({i - n - 1, i - n, i});
      mesh.triangles.push_back({i - n - 1, i, i - 1});
    }
  }
  return mesh;
}

TEST(GlbCompression, IsReadBackWithinItsPromise) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = sheet(40);
  const auto path = folder.path() / "sheet.glb";
  write_glb(path, mesh, GlbNumbers::compressed);
  const TriangleMesh back = read_glb(path).mesh;
  ASSERT_EQ(back.vertices_m.size(), mesh.vertices_m.size());
  ASSERT_EQ(back.normals.size(), mesh.normals.size());
  ASSERT_EQ(back.colors_rgb.size(), mesh.colors_rgb.size());
  ASSERT_EQ(back.triangles.size(), mesh.triangles.size());
  // Vertices are found again by their colours.
  std::map<std::array<uint8_t, 3>, std::size_t> by_color;
  for (std::size_t i = 0; i < 1600; ++i) by_color[mesh.colors_rgb[i]] = i;
  std::vector<uint32_t> old_of(1600);
  for (std::size_t i = 0; i < 1600; ++i) {
    const auto found = by_color.find(back.colors_rgb[i]);
    ASSERT_NE(found, by_color.end());
    const std::size_t old = found->second;
    old_of[i] = static_cast<uint32_t>(old);
    EXPECT_LE((back.vertices_m[i] - mesh.vertices_m[old]).cwiseAbs().maxCoeff(), kHalfStepM);
    EXPECT_GT(back.normals[i].dot(mesh.normals[old]), std::cos(2.0F * 0.01745F));
    EXPECT_NEAR(back.normals[i].norm(), 1.0F, 1e-5F);
  }
  // The same triangles, whatever their order and first corner: they face the same way.
  const auto first_least = [](std::array<uint32_t, 3> t) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
  };
  std::vector<std::array<uint32_t, 3>> expected, found;
  for (const auto& t : mesh.triangles) expected.push_back(first_least(t));
  for (const auto& t : back.triangles) {
    found.push_back(first_least({old_of[t[0]], old_of[t[1]], old_of[t[2]]}));
  }
  EXPECT_THAT(found, ::testing::UnorderedElementsAreArray(expected));
}

TEST(GlbCompression, TakesLessThanTwoFifths) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = sheet(40);
  const auto size = [&](GlbNumbers numbers) {
    write_glb(folder.path() / "sheet.glb", mesh, numbers);
    return std::filesystem::file_size(folder.path() / "sheet.glb");
  };
  EXPECT_LT(5 * size(GlbNumbers::compressed), 2 * size(GlbNumbers::plain));
}

TexturedMesh painted() {
  TexturedMesh textured{sheet(3), {}, std::string("\x89PNG\r\n\x1a\n", 8) + "not decoded here"};
  textured.mesh.colors_rgb.clear();
  for (int i = 0; i < 9; ++i) {
    textured.uvs.emplace_back(static_cast<float>(i) / 8.0F, 1.0F - static_cast<float>(i) / 8.0F);
  }
  return textured;
}

TEST(GlbCompression, CarriesItsPictureAndUvs) {
  const TemporaryFolder folder;
  TexturedMesh textured = painted();
  write_glb(folder.path() / "p.glb", textured, GlbNumbers::compressed);
  const TexturedMesh back = read_glb(folder.path() / "p.glb");
  EXPECT_EQ(back.image, textured.image);
  ASSERT_EQ(back.uvs.size(), 9U);
  for (std::size_t i = 0; i < 9; ++i) {
    const Eigen::Vector3f at = back.mesh.vertices_m[i];
    const auto old = static_cast<std::size_t>(std::lround((at.x() - 100.0F) / 0.05F) +
                                              3 * std::lround(at.y() / 0.05F));
    EXPECT_LT((back.uvs[i] - textured.uvs.at(old)).cwiseAbs().maxCoeff(), 1.0F / 65535.0F);
  }
  textured.uvs[0].x() = 1.01F;
  EXPECT_THROW(write_glb(folder.path() / "p.glb", textured, GlbNumbers::compressed),
               std::invalid_argument);
}

TEST(GlbCompression, LeavesOutVerticesOfNoTriangleAndRefusesTheFarAway) {
  const TemporaryFolder folder;
  TriangleMesh mesh = sheet(3);
  mesh.triangles.resize(1);
  write_glb(folder.path() / "m.glb", mesh, GlbNumbers::compressed);
  EXPECT_EQ(read_glb(folder.path() / "m.glb").mesh.vertices_m.size(), 3U);
  mesh.vertices_m[0].x() = -8193.0F;
  EXPECT_THROW(write_glb(folder.path() / "m.glb", mesh, GlbNumbers::compressed),
               std::invalid_argument);
  mesh.triangles.clear();
  write_glb(folder.path() / "m.glb", mesh, GlbNumbers::compressed);
  EXPECT_TRUE(read_glb(folder.path() / "m.glb").mesh.vertices_m.empty());
}

// Any bit of it wrong: read otherwise, or refused, and nothing else.
TEST(GlbCompression, DamagedOnesAreRefused) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "p.glb";
  write_glb(path, painted(), GlbNumbers::compressed);
  const std::string whole = read_whole_file(path);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < whole.size(); i += 3) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 7)));
    if (i % 5 == 0) damaged.resize(i);
    try {
      read_glb(folder.write("damaged.glb", damaged));
    } catch (const std::invalid_argument&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, whole.size() / 12);
}

// A few bytes cannot become gigabytes.
TEST(GlbCompression, CountsThatTheBytesCannotHoldAreRefused) {
  const TemporaryFolder folder;
  write_glb(folder.path() / "p.glb", painted(), GlbNumbers::compressed);
  std::string whole = read_whole_file(folder.path() / "p.glb");
  const auto complaint = [&](const std::string& from, const std::string& to) -> std::string {
    std::string changed = whole;
    for (auto at = changed.find(from); at != std::string::npos; at = changed.find(from, at + 1)) {
      changed.replace(at, from.size(), to);
    }
    try {
      read_glb(folder.write("h.glb", changed));
    } catch (const std::invalid_argument& refused) {
      return refused.what();
    }
    return "read";
  };
  EXPECT_THAT(complaint("\"byteStride\":12", "\"byteStride\":-8"),
              ::testing::HasSubstr("ends inside its compressed numbers"));
  EXPECT_THAT(complaint("EXPONENTIAL", "EXPONENTIOL"), ::testing::HasSubstr("unknown filter"));
  EXPECT_THAT(complaint("TRIANGLES", "TRIANGLEZ"), ::testing::HasSubstr("unknown way"));
  // A longer number, in the room of a word: the lengths in the file stay right.
  whole.replace(whole.find("\"marco\""), 7, "\"\"");
  EXPECT_THAT(complaint("\"byteStride\":4,\"count\":24", "\"byteStride\":4,\"count\":2400000"),
              ::testing::HasSubstr("ends inside its compressed numbers"));
}

}  // namespace
}  // namespace marco::files
