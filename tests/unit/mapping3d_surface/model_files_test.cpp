// What we write, opened by a reader that is not ours (Assimp).
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <assimp/Importer.hpp>

#include "common/files/glb.hpp"
#include "common/files/obj.hpp"
#include "common/files/ply.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::files {
namespace {

using testing::TemporaryFolder;

// A tent: four vertices, three faces, no two alike.
TriangleMesh tent() {
  TriangleMesh mesh;
  mesh.vertices_m = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0.5F, 0.5F, 1.25F}};
  mesh.normals = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.colors_rgb = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {51, 102, 204}};
  mesh.triangles = {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return mesh;
}

struct Seen {
  std::vector<Eigen::Vector3f> corners_m;  ///< of each triangle, as read
  std::vector<Eigen::Vector3f> normals;
  std::vector<Eigen::Vector3f> colors;
  aiMatrix4x4 node;
};

// Vertices may be doubled or sorted anew by the reader: triangles' corners are compared.
Seen read_by_another(const std::filesystem::path& path) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path.string(), 0);
  EXPECT_NE(scene, nullptr) << importer.GetErrorString();
  Seen seen;
  if (scene == nullptr || scene->mNumMeshes != 1) {
    ADD_FAILURE() << path << ": expected one mesh";
    return seen;
  }
  const aiMesh& mesh = *scene->mMeshes[0];
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    EXPECT_EQ(mesh.mFaces[f].mNumIndices, 3U);
    for (unsigned i = 0; i < 3; ++i) {
      const unsigned v = mesh.mFaces[f].mIndices[i];
      seen.corners_m.emplace_back(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z);
      if (mesh.HasNormals()) {
        seen.normals.emplace_back(mesh.mNormals[v].x, mesh.mNormals[v].y, mesh.mNormals[v].z);
      }
      if (mesh.HasVertexColors(0)) {
        const aiColor4D& c = mesh.mColors[0][v];
        seen.colors.emplace_back(c.r, c.g, c.b);
      }
    }
  }
  const aiNode* node = scene->mRootNode;
  while (node->mNumMeshes == 0 && node->mNumChildren > 0) node = node->mChildren[0];
  seen.node = node->mTransformation;
  return seen;
}

void expect_tent(const Seen& seen) {
  const TriangleMesh mesh = tent();
  ASSERT_EQ(seen.corners_m.size(), 9U);
  ASSERT_EQ(seen.normals.size(), 9U);
  ASSERT_EQ(seen.colors.size(), 9U);
  for (std::size_t i = 0; i < 9; ++i) {
    const uint32_t v = mesh.triangles[i / 3][i % 3];
    EXPECT_LT((seen.corners_m[i] - mesh.vertices_m[v]).norm(), 1e-4F);
    EXPECT_LT((seen.normals[i] - mesh.normals[v]).norm(), 1e-3F);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(seen.colors[i][c], mesh.colors_rgb[v][static_cast<std::size_t>(c)] / 255.0F,
                  2e-3F);
    }
  }
}

TEST(ModelFiles, PlyIsReadByAnother) {
  const TemporaryFolder folder;
  write_ply(folder.path() / "tent.ply", tent());
  expect_tent(read_by_another(folder.path() / "tent.ply"));
}

TEST(ModelFiles, ObjIsReadByAnother) {
  const TemporaryFolder folder;
  write_obj(folder.path() / "tent.obj", tent());
  expect_tent(read_by_another(folder.path() / "tent.obj"));
}

TEST(ModelFiles, GlbIsReadByAnotherAndStandsUpright) {
  const TemporaryFolder folder;
  write_glb(folder.path() / "tent.glb", tent());
  const Seen seen = read_by_another(folder.path() / "tent.glb");
  expect_tent(seen);
  // glTF's y is up: our z must come out there.
  const aiVector3D up = seen.node * aiVector3D(0, 0, 1);
  EXPECT_NEAR(up.x, 0.0F, 1e-6F);
  EXPECT_NEAR(up.y, 1.0F, 1e-6F);
  EXPECT_NEAR(up.z, 0.0F, 1e-6F);
}

TEST(ModelFiles, GlbCarriesItsPicture) {
  const TemporaryFolder folder;
  TexturedMesh textured;
  textured.mesh = tent();
  textured.mesh.colors_rgb.clear();
  textured.uvs = {{0, 0}, {1, 0}, {0, 1}, {0.25F, 0.75F}};
  textured.image = std::string("\x89PNG\r\n\x1a\n", 8) + "not decoded here";
  write_glb(folder.path() / "tent.glb", textured);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile((folder.path() / "tent.glb").string(), 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  ASSERT_EQ(scene->mNumTextures, 1U);
  const aiTexture& texture = *scene->mTextures[0];
  EXPECT_STREQ(texture.achFormatHint, "png");
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(texture.pcData), texture.mWidth),
            textured.image);
  ASSERT_TRUE(scene->mMeshes[0]->HasTextureCoords(0));
  // Assimp's v runs upwards.
  const aiFace& face = scene->mMeshes[0]->mFaces[0];
  const aiVector3D uv = scene->mMeshes[0]->mTextureCoords[0][face.mIndices[2]];
  EXPECT_NEAR(uv.x, 0.25F, 1e-6F);
  EXPECT_NEAR(uv.y, 0.25F, 1e-6F);
}

TEST(ModelFiles, GlbIsReadBackAsItWasAndTornOnesAreRefused) {
  const TemporaryFolder folder;
  TexturedMesh textured;
  textured.mesh = tent();
  textured.uvs = {{0, 0}, {1, 0}, {0, 1}, {0.25F, 0.75F}};
  textured.image = std::string("\x89PNG\r\n\x1a\n", 8) + "not decoded here";
  const auto path = folder.path() / "tent.glb";
  write_glb(path, textured);
  const TexturedMesh back = read_glb(path);
  EXPECT_EQ(back.mesh.vertices_m, textured.mesh.vertices_m);
  EXPECT_EQ(back.mesh.normals, textured.mesh.normals);
  EXPECT_EQ(back.mesh.colors_rgb, textured.mesh.colors_rgb);
  EXPECT_EQ(back.mesh.triangles, textured.mesh.triangles);
  EXPECT_EQ(back.uvs, textured.uvs);
  EXPECT_EQ(back.image, textured.image);
  write_glb(folder.path() / "none.glb", TriangleMesh{});
  EXPECT_TRUE(read_glb(folder.path() / "none.glb").mesh.triangles.empty());
  // Any bit of it wrong: read otherwise, or refused, and nothing else.
  const std::string whole = read_whole_file(path);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string torn = whole;
    torn[i] = static_cast<char>(torn[i] ^ (1 << (i % 7)));
    if (i % 5 == 0) torn.resize(i);
    try {
      read_glb(folder.write("torn.glb", torn));
    } catch (const std::invalid_argument&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, whole.size() / 4);
}

std::string glb_of(const std::string& description) {
  std::string text = description;
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto number = [](std::size_t value) {
    std::string bytes;
    for (unsigned shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift);
    return bytes;
  };
  return "glTF" + number(2) + number(20 + text.size() + 8 + 12) + number(text.size()) + "JSON" +
         text + number(12) + std::string("BIN\0", 4) + std::string(12, '\0');
}

// Each names what it does not hold: another file, bytes behind its end, numbers of another kind.
TEST(ModelFiles, HostileGlbIsRefusedWithAWord) {
  const TemporaryFolder folder;
  folder.write("secret.bin", std::string(12, 's'));
  const std::string mesh =
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3"},)"
      R"({"bufferView":1,"componentType":5125,"type":"SCALAR"}],)";
  const auto views = [](const std::string& first) {
    return R"("bufferViews":[)" + first + R"(,{"byteLength":0}],)";
  };
  const auto complaint = [&](const std::string& description) -> std::string {
    try {
      read_glb(folder.write("hostile.glb", glb_of("{" + description + R"("asset":{}})")));
    } catch (const std::invalid_argument& refused) {
      return refused.what();
    }
    return "read";
  };
  EXPECT_EQ(complaint(mesh + views(R"({"byteLength":12})")), "read");
  EXPECT_THAT(complaint(mesh + views(R"({"byteLength":400000000,"byteOffset":300000000})")),
              ::testing::HasSubstr("ends inside its numbers"));
  EXPECT_THAT(complaint(mesh + views(R"({"byteLength":12,"byteOffset":18446744073709551610})")),
              ::testing::HasSubstr("ends inside its numbers"));
  EXPECT_THAT(complaint(mesh + views(R"({"byteLength":11})")),
              ::testing::HasSubstr("truncated numbers"));
  EXPECT_THAT(complaint(mesh + views(R"({"uri":"secret.bin"})")), ::testing::HasSubstr("lacks"));
  EXPECT_THAT(complaint(views(R"({"byteLength":12})") + R"("meshes":[{"primitives":[{}]}],)"),
              ::testing::HasSubstr("lacks"));
  EXPECT_THAT(complaint(mesh + views(R"({"byteLength":12})") + R"("images":[{"bufferView":7}],)"),
              ::testing::HasSubstr("lacks"));
  EXPECT_THAT(complaint(std::string(100000, '[')), ::testing::HasSubstr("not JSON"));
}

TEST(ModelFiles, WhatCannotBeWrittenIsSaid) {
  const TemporaryFolder folder;
  TriangleMesh torn = tent();
  torn.normals.pop_back();
  EXPECT_THROW(write_obj(folder.path() / "a.obj", torn), std::invalid_argument);
  EXPECT_THROW(write_glb(folder.path() / "a.glb", torn), std::invalid_argument);
  TexturedMesh textured{tent(), {{0, 0}, {0, 0}, {0, 0}, {0, 0}}, "GIF89a"};
  EXPECT_THROW(write_glb(folder.path() / "a.glb", textured), std::invalid_argument);
  // A mesh of nothing is a file of nothing.
  write_glb(folder.path() / "none.glb", TriangleMesh{});
  EXPECT_EQ(read_whole_file(folder.path() / "none.glb").substr(0, 4), "glTF");
  write_obj(folder.path() / "none.obj", TriangleMesh{});
  EXPECT_EQ(read_whole_file(folder.path() / "none.obj").find("\nv "), std::string::npos);
}

}  // namespace
}  // namespace marco::files
