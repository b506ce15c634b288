#include "common/files/glb.hpp"

#include <cstring>
#include <nlohmann/json.hpp>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {
namespace {

using nlohmann::json;

// Numbers of the glTF 2.0 specification.
constexpr int kFloat = 5126, kUnsignedByte = 5121, kUnsignedInt = 5125;
constexpr int kVertices = 34962, kIndices = 34963;
constexpr int kLinear = 9729, kLinearMipmap = 9987, kClamp = 33071, kTriangles = 4;

class GlbBuilder {
 public:
  /// @returns the number of the new accessor.
  std::size_t add(const void* data, std::size_t bytes, int target, json accessor) {
    accessor["bufferView"] = add_view(data, bytes, target);
    accessors_.push_back(std::move(accessor));
    return accessors_.size() - 1;
  }
  std::size_t add_view(const void* data, std::size_t bytes, int target) {
    json view = {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes}};
    if (target != 0) view["target"] = target;
    views_.push_back(std::move(view));
    binary_.append(static_cast<const char*>(data), bytes);
    binary_.resize((binary_.size() + 3) / 4 * 4, '\0');
    return views_.size() - 1;
  }
  std::string finish(json document) {
    if (!accessors_.empty()) document["accessors"] = accessors_;
    if (!views_.empty()) document["bufferViews"] = views_;
    if (!binary_.empty()) document["buffers"] = {{{"byteLength", binary_.size()}}};
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string file = "glTF";
    const std::size_t total = 12 + 8 + text.size() + (binary_.empty() ? 0 : 8 + binary_.size());
    require(total < 0xFFFFFFFFU, "write_glb: a GLB holds at most 4 GB");
    append(file, 2);
    append(file, total);
    append(file, text.size());
    file += "JSON" + text;
    if (!binary_.empty()) {
      append(file, binary_.size());
      file += std::string("BIN\0", 4) + binary_;
    }
    return file;
  }

 private:
  static void append(std::string& file, std::size_t value) {
    for (unsigned shift = 0; shift < 32; shift += 8) {
      file += static_cast<char>((value >> shift) & 0xFFU);
    }
  }
  json accessors_ = json::array();
  json views_ = json::array();
  std::string binary_;
};

std::size_t add_positions(GlbBuilder& builder, const std::vector<Eigen::Vector3f>& vertices_m) {
  Eigen::Vector3f low = vertices_m.front(), high = vertices_m.front();
  for (const Eigen::Vector3f& vertex : vertices_m) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  return builder.add(vertices_m.data(), 12 * vertices_m.size(), kVertices,
                     {{"componentType", kFloat},
                      {"count", vertices_m.size()},
                      {"type", "VEC3"},
                      {"min", {low.x(), low.y(), low.z()}},
                      {"max", {high.x(), high.y(), high.z()}}});
}

std::size_t add_colors(GlbBuilder& builder, const std::vector<std::array<uint8_t, 3>>& colors_rgb) {
  std::string rgba;  // a vertex's colour starts at a multiple of four bytes
  for (const auto& c : colors_rgb) {
    rgba += {static_cast<char>(c[0]), static_cast<char>(c[1]), static_cast<char>(c[2]), '\xFF'};
  }
  return builder.add(rgba.data(), rgba.size(), kVertices,
                     {{"componentType", kUnsignedByte},
                      {"normalized", true},
                      {"count", colors_rgb.size()},
                      {"type", "VEC4"}});
}

json primitive(GlbBuilder& builder,
               const TriangleMesh& mesh,
               const std::vector<Eigen::Vector2f>& uvs) {
  json attributes;
  const std::size_t count = mesh.vertices_m.size();
  attributes["POSITION"] = add_positions(builder, mesh.vertices_m);
  if (!mesh.normals.empty()) {
    attributes["NORMAL"] =
        builder.add(mesh.normals.data(), 12 * count, kVertices,
                    {{"componentType", kFloat}, {"count", count}, {"type", "VEC3"}});
  }
  if (!mesh.colors_rgb.empty()) attributes["COLOR_0"] = add_colors(builder, mesh.colors_rgb);
  if (!uvs.empty()) {
    attributes["TEXCOORD_0"] =
        builder.add(uvs.data(), 8 * count, kVertices,
                    {{"componentType", kFloat}, {"count", count}, {"type", "VEC2"}});
  }
  const std::size_t indices = builder.add(
      mesh.triangles.data(), 12 * mesh.triangles.size(), kIndices,
      {{"componentType", kUnsignedInt}, {"count", 3 * mesh.triangles.size()}, {"type", "SCALAR"}});
  return {{"attributes", attributes}, {"indices", indices}, {"mode", kTriangles}, {"material", 0}};
}

void write(const std::filesystem::path& path,
           const TriangleMesh& mesh,
           const std::vector<Eigen::Vector2f>& uvs,
           const std::string& image) {
  const std::size_t count = mesh.vertices_m.size();
  require((mesh.normals.empty() || mesh.normals.size() == count) &&
              (mesh.colors_rgb.empty() || mesh.colors_rgb.size() == count) &&
              (uvs.empty() || uvs.size() == count),
          "write_glb: normals, colours and uvs need one a vertex");
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
    require(png || image.rfind("\xFF\xD8", 0) == 0, "write_glb: the picture is no PNG and no JPEG");
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
  document["meshes"] = {{{"primitives", json::array({primitive(builder, mesh, uvs)})}}};
  const double half = 0.7071067811865476;  // -90 deg about x
  document["nodes"] = {{{"mesh", 0}, {"rotation", {-half, 0.0, 0.0, half}}}};
  document["scenes"] = {{{"nodes", {0}}}};
  write_whole_file(path, builder.finish(std::move(document)));
}

}  // namespace

void write_glb(const std::filesystem::path& path, const TriangleMesh& mesh) {
  write(path, mesh, {}, {});
}

void write_glb(const std::filesystem::path& path, const TexturedMesh& textured) {
  require(textured.mesh.triangles.empty() || (!textured.uvs.empty() && !textured.image.empty()),
          "write_glb: a textured mesh needs uvs and a picture");
  write(path, textured.mesh, textured.uvs, textured.image);
}

}  // namespace marco::files
