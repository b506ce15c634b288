#include "common/files/ply.hpp"

#include <bit>
#include <cstring>
#include <sstream>
#include <string>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/output_file.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY is written as the machine has it");

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

struct PlyHeader {
  std::size_t vertices = 0;
  std::size_t faces = 0;
  bool normals = false;
  bool colors = false;
  std::size_t bytes = 0;
};

PlyHeader parse_header(const std::string& content, const std::string& name) {
  PlyHeader header;
  std::istringstream lines(content.substr(0, 4096));
  std::string line;
  bool binary = false, ended = false;
  while (!ended && std::getline(lines, line)) {
    header.bytes += line.size() + 1;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::istringstream words(line);
    std::string first, second, third;
    words >> first >> second >> third;
    binary = binary || (first == "format" && second == "binary_little_endian");
    if (first == "element" && second == "vertex") header.vertices = std::stoull("0" + third);
    if (first == "element" && second == "face") header.faces = std::stoull("0" + third);
    header.normals = header.normals || third == "nx";
    header.colors = header.colors || third == "red";
    ended = first == "end_header";
  }
  require(content.rfind("ply", 0) == 0 && binary && ended,
          name + ": expected a binary little-endian PLY");
  return header;
}

class Bytes {
 public:
  Bytes(const std::string& content, std::size_t start, std::string name)
      : content_(content), at_(start), name_(std::move(name)) {}
  template <class T>
  T take() {
    require(at_ + sizeof(T) <= content_.size(), name_ + ": ends before its last element");
    T value;
    std::memcpy(&value, content_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  Eigen::Vector3f take_vector() {
    const auto x = take<float>(), y = take<float>(), z = take<float>();
    return {x, y, z};
  }

 private:
  const std::string& content_;
  std::size_t at_;
  std::string name_;
};

}  // namespace

void write_ply(const std::filesystem::path& path, const TriangleMesh& mesh) {
  const bool normals = !mesh.normals.empty(), colors = !mesh.colors_rgb.empty();
  require((!normals || mesh.normals.size() == mesh.vertices_m.size()) &&
              (!colors || mesh.colors_rgb.size() == mesh.vertices_m.size()),
          "write_ply: expected one normal and colour per vertex, or none");
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment metres, x forward, y left, z up\n";
  bytes += "element vertex " + std::to_string(mesh.vertices_m.size()) +
           "\nproperty float x\nproperty float y\nproperty float z\n";
  if (normals) bytes += "property float nx\nproperty float ny\nproperty float nz\n";
  if (colors) bytes += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  bytes += "element face " + std::to_string(mesh.triangles.size()) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
  OutputFile file(path);
  const auto write = [&] {
    file.write(bytes);
    bytes.clear();
  };
  write();
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) append(bytes, mesh.vertices_m[i](axis));
    for (int axis = 0; normals && axis < 3; ++axis) append(bytes, mesh.normals[i](axis));
    if (colors) append(bytes, mesh.colors_rgb[i]);
    write();
  }
  for (const auto& triangle : mesh.triangles) {
    append(bytes, uint8_t{3});
    append(bytes, triangle);
    write();
  }
  file.finish();
}

TriangleMesh read_ply(const std::filesystem::path& path) {
  const std::string content = read_whole_file(path);
  const PlyHeader header = parse_header(content, path.string());
  // Checked before memory is allocated.
  const std::size_t vertex_bytes = 12U + (header.normals ? 12U : 0U) + (header.colors ? 3U : 0U);
  require(header.vertices <= content.size() / vertex_bytes && header.faces <= content.size() / 13,
          path.string() + ": its header declares more elements than the file holds");
  Bytes bytes(content, header.bytes, path.string());
  TriangleMesh mesh;
  for (std::size_t i = 0; i < header.vertices; ++i) {
    mesh.vertices_m.push_back(bytes.take_vector());
    if (header.normals) mesh.normals.push_back(bytes.take_vector());
    if (header.colors) mesh.colors_rgb.push_back(bytes.take<std::array<uint8_t, 3>>());
  }
  for (std::size_t i = 0; i < header.faces; ++i) {
    require(bytes.take<uint8_t>() == 3, path.string() + ": only triangles are read");
    mesh.triangles.push_back(bytes.take<std::array<uint32_t, 3>>());
    for (const uint32_t vertex : mesh.triangles.back()) {
      require(vertex < header.vertices,
              path.string() + ": a face refers to a vertex that does not exist");
    }
  }
  return mesh;
}

}  // namespace marco::files
