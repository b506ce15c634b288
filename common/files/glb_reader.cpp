#include <cstring>
#include <nlohmann/json.hpp>

#include "common/files/glb.hpp"
#include "common/files/glb_compression.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {
namespace {

using nlohmann::json;

uint32_t number_at(const std::string& file, std::size_t place) {
  uint32_t number = 0;
  for (std::size_t i = 4; i-- > 0;) {
    number = number << 8 | static_cast<uint8_t>(file[place + i]);
  }
  return number;
}

// The two chunks of a file, and what the first says of the second.
class Glb {
 public:
  explicit Glb(const std::string& file) {
    require(file.size() >= 20 && file.rfind("glTF", 0) == 0, "is not a GLB");
    const std::size_t text_bytes = number_at(file, 12);
    require(text_bytes <= file.size() - 20, "ends inside its description");
    document_ = json::parse(file.substr(20, text_bytes), nullptr, false);
    require(document_.is_object(), "its description is not JSON");
    const std::size_t start = 20 + text_bytes + 8;
    if (start <= file.size()) binary_ = file.substr(start);
  }

  const json& document() const { return document_; }

  std::string view(const json& index) const {
    const json& entry = document_.at("bufferViews").at(index.get<std::size_t>());
    if (entry.contains("extensions") && entry.at("extensions").contains(kMeshopt)) {
      const json& packed = entry.at("extensions").at(kMeshopt);
      return unpacked(bytes_of(packed), packed);
    }
    return std::string(bytes_of(entry));
  }

  const json& accessor(const json& index) const {
    return document_.at("accessors").at(index.get<std::size_t>());
  }

  // The numbers of an accessor of just this shape, one after another.
  template <class T>
  std::vector<T> values(const json& index, int component, const char* type) const {
    const json& entry = accessor(index);
    require(entry.at("componentType") == component && entry.at("type") == type,
            "contains number types that write_glb does not write");
    const std::string bytes = view(entry.at("bufferView"));
    std::vector<T> values(bytes.size() / sizeof(T));
    require(bytes.size() % sizeof(T) == 0, "has truncated numbers");
    if (!values.empty()) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
    return values;
  }

 private:
  std::string_view bytes_of(const json& place) const {
    const auto start = place.value("byteOffset", std::size_t{0});
    const auto bytes = place.at("byteLength").get<std::size_t>();
    require(start <= binary_.size() && bytes <= binary_.size() - start, "ends inside its numbers");
    return std::string_view(binary_).substr(start, bytes);
  }

  json document_;
  std::string binary_;
};

std::vector<Eigen::Vector3f> normals_of(const Glb& glb, const json& index) {
  if (glb.accessor(index).at("componentType") != kGlbByte) {
    return glb.values<Eigen::Vector3f>(index, kGlbFloat, "VEC3");
  }
  std::vector<Eigen::Vector3f> normals;
  for (const auto& n : glb.values<std::array<int8_t, 4>>(index, kGlbByte, "VEC3")) {
    normals.emplace_back(Eigen::Vector3f(n[0], n[1], n[2]).normalized());
  }
  return normals;
}

std::vector<Eigen::Vector2f> uvs_of(const Glb& glb, const json& index) {
  if (glb.accessor(index).at("componentType") != kGlbUnsignedShort) {
    return glb.values<Eigen::Vector2f>(index, kGlbFloat, "VEC2");
  }
  std::vector<Eigen::Vector2f> uvs;
  for (const auto& uv : glb.values<std::array<uint16_t, 2>>(index, kGlbUnsignedShort, "VEC2")) {
    uvs.emplace_back(Eigen::Vector2f(uv[0], uv[1]) / 65535.0F);
  }
  return uvs;
}

TexturedMesh mesh_of(const Glb& glb) {
  TexturedMesh textured;
  if (!glb.document().contains("meshes")) return textured;
  const json& primitive = glb.document().at("meshes").at(0).at("primitives").at(0);
  const json& attributes = primitive.at("attributes");
  TriangleMesh& mesh = textured.mesh;
  mesh.vertices_m = glb.values<Eigen::Vector3f>(attributes.at("POSITION"), kGlbFloat, "VEC3");
  if (attributes.contains("NORMAL")) {
    mesh.normals = normals_of(glb, attributes.at("NORMAL"));
  }
  if (attributes.contains("TEXCOORD_0")) {
    textured.uvs = uvs_of(glb, attributes.at("TEXCOORD_0"));
  }
  if (attributes.contains("COLOR_0")) {
    for (const auto& c :
         glb.values<std::array<uint8_t, 4>>(attributes.at("COLOR_0"), kGlbUnsignedByte, "VEC4")) {
      mesh.colors_rgb.push_back({c[0], c[1], c[2]});
    }
  }
  const auto indices = glb.values<uint32_t>(primitive.at("indices"), kGlbUnsignedInt, "SCALAR");
  const std::size_t count = mesh.vertices_m.size();
  const auto one_each = [count](std::size_t size) { return size == 0 || size == count; };
  require(indices.size() % 3 == 0 && one_each(mesh.normals.size()) &&
              one_each(mesh.colors_rgb.size()) && one_each(textured.uvs.size()),
          "has lists of different lengths");
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    mesh.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
    require(indices[i] < count && indices[i + 1] < count && indices[i + 2] < count,
            "has a triangle that names a missing vertex");
  }
  for (const Eigen::Vector3f& vertex : mesh.vertices_m) {
    require(vertex.allFinite(), "has a vertex that is not finite");
  }
  if (glb.document().contains("images")) {
    textured.image = glb.view(glb.document().at("images").at(0).at("bufferView"));
  }
  return textured;
}

}  // namespace

TexturedMesh read_glb(const std::filesystem::path& path) {
  try {
    return mesh_of(Glb(read_whole_file(path)));
  } catch (const json::exception&) {
    throw std::invalid_argument(path.string() + ": lacks parts that write_glb writes");
  } catch (const std::invalid_argument& fault) {
    throw std::invalid_argument(path.string() + ": " + fault.what());
  }
}

}  // namespace marco::files
