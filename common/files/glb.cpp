#include "common/files/glb.hpp"

#include "common/files/glb_builder.hpp"
#include "common/files/glb_compression.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {
namespace {

using nlohmann::json;

constexpr int kLinear = 9729, kLinearMipmap = 9987, kClamp = 33071, kTriangles = 4;

json plain_numbers(GlbBuilder& builder,
                   const TriangleMesh& mesh,
                   const std::vector<Eigen::Vector2f>& uvs) {
  json attributes;
  const std::size_t count = mesh.vertices_m.size();
  attributes["POSITION"] =
      builder.add(mesh.vertices_m.data(), 12 * count, kGlbVertices, glb_positions(mesh.vertices_m));
  if (!mesh.normals.empty()) {
    attributes["NORMAL"] =
        builder.add(mesh.normals.data(), 12 * count, kGlbVertices,
                    {{"componentType", kGlbFloat}, {"count", count}, {"type", "VEC3"}});
  }
  if (!mesh.colors_rgb.empty()) {
    const auto rgba = glb_colors(mesh.colors_rgb);
    attributes["COLOR_0"] = builder.add(rgba.data(), 4 * count, kGlbVertices,
                                        {{"componentType", kGlbUnsignedByte},
                                         {"normalized", true},
                                         {"count", count},
                                         {"type", "VEC4"}});
  }
  if (!uvs.empty()) {
    attributes["TEXCOORD_0"] =
        builder.add(uvs.data(), 8 * count, kGlbVertices,
                    {{"componentType", kGlbFloat}, {"count", count}, {"type", "VEC2"}});
  }
  const std::size_t indices =
      builder.add(mesh.triangles.data(), 12 * mesh.triangles.size(), kGlbIndices,
                  {{"componentType", kGlbUnsignedInt},
                   {"count", 3 * mesh.triangles.size()},
                   {"type", "SCALAR"}});
  return {{"attributes", attributes}, {"indices", indices}};
}

void write(const std::filesystem::path& path,
           const TriangleMesh& mesh,
           const std::vector<Eigen::Vector2f>& uvs,
           const std::string& image,
           GlbNumbers numbers) {
  const std::size_t count = mesh.vertices_m.size();
  require((mesh.normals.empty() || mesh.normals.size() == count) &&
              (mesh.colors_rgb.empty() || mesh.colors_rgb.size() == count) &&
              (uvs.empty() || uvs.size() == count),
          "write_glb: expected one normal, colour and uv per vertex");
  GlbBuilder builder;
  json document = {{"asset", {{"version", "2.0"}, {"generator", "marco"}}}, {"scene", 0}};
  if (mesh.triangles.empty()) {  // glTF knows no empty mesh
    document["scenes"] = {{{"name", "empty"}}};
    write_whole_file(path, builder.finish(std::move(document)));
    return;
  }
  json surface = {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}};
  if (!image.empty()) {
    const bool png = image.rfind("\x89PNG", 0) == 0;
    require(png || image.rfind("\xFF\xD8", 0) == 0,
            "write_glb: the picture is neither PNG nor JPEG");
    const std::size_t view = builder.add_view(image.data(), image.size(), 0);
    document["images"] = {{{"bufferView", view}, {"mimeType", png ? "image/png" : "image/jpeg"}}};
    document["samplers"] = {{{"magFilter", kLinear},
                             {"minFilter", kLinearMipmap},
                             {"wrapS", kClamp},
                             {"wrapT", kClamp}}};
    document["textures"] = {{{"source", 0}, {"sampler", 0}}};
    surface["baseColorTexture"] = {{"index", 0}};
  }
  document["materials"] = {{{"pbrMetallicRoughness", surface}, {"doubleSided", true}}};
  json primitive = numbers == GlbNumbers::compressed ? compressed_numbers(builder, mesh, uvs)
                                                     : plain_numbers(builder, mesh, uvs);
  primitive.update({{"mode", kTriangles}, {"material", 0}});
  document["meshes"] = {{{"primitives", json::array({std::move(primitive)})}}};
  const double half = 0.7071067811865476;  // -90 deg about x
  document["nodes"] = {{{"mesh", 0}, {"rotation", {-half, 0.0, 0.0, half}}}};
  document["scenes"] = {{{"nodes", {0}}}};
  write_whole_file(path, builder.finish(std::move(document)));
}

}  // namespace

void write_glb(const std::filesystem::path& path, const TriangleMesh& mesh, GlbNumbers numbers) {
  write(path, mesh, {}, {}, numbers);
}

void write_glb(const std::filesystem::path& path,
               const TexturedMesh& textured,
               GlbNumbers numbers) {
  require(textured.mesh.triangles.empty() || (!textured.uvs.empty() && !textured.image.empty()),
          "write_glb: a textured mesh needs uvs and a picture");
  write(path, textured.mesh, textured.uvs, textured.image, numbers);
}

}  // namespace marco::files
