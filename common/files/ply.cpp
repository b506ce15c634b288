#include "common/files/ply.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/files/ply_elements.hpp"
#include "common/files/point_columns.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/output_file.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {
namespace {

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Where the parts of a vertex lie among the wanted numbers.
struct VertexSlots {
  std::optional<std::size_t> normal, color;
  std::array<Scalar, 3> color_types{};
};

void read_vertices(PlyElements& ply,
                   const PlyElement& element,
                   TriangleMesh& mesh,
                   const std::string& name) {
  const std::vector<std::string> names = element.number_names();
  const PointColumns columns = find_point_columns(names);
  require(columns.xyz.has_value(), name + ": its vertices have no x, y, z");
  PlyElements::Wanted wanted{{columns.xyz->begin(), columns.xyz->end()}, std::nullopt};
  VertexSlots slots;
  if (columns.normal) {
    slots.normal = wanted.numbers.size();
    wanted.numbers.insert(wanted.numbers.end(), columns.normal->begin(), columns.normal->end());
    mesh.normals.reserve(element.count);
  }
  if (columns.rgb) {
    slots.color = wanted.numbers.size();
    for (std::size_t i = 0; i < 3; ++i) {
      wanted.numbers.push_back((*columns.rgb)[i]);
      slots.color_types[i] = element.properties[(*columns.rgb)[i]].type;
    }
    mesh.colors_rgb.reserve(element.count);
  }
  mesh.vertices_m.reserve(element.count);
  ply.read_next(wanted, [&](std::span<const double> v, std::span<const double>) {
    const auto vector_at = [v](std::size_t i) {
      return Eigen::Vector3f(static_cast<float>(v[i]), static_cast<float>(v[i + 1]),
                             static_cast<float>(v[i + 2]));
    };
    mesh.vertices_m.push_back(vector_at(0));
    if (slots.normal) mesh.normals.push_back(vector_at(*slots.normal));
    if (!slots.color) return;
    const double* const rgb = &v[*slots.color];
    const auto& types = slots.color_types;
    mesh.colors_rgb.push_back(
        {color_byte(rgb[0], types[0]), color_byte(rgb[1], types[1]), color_byte(rgb[2], types[2])});
  });
}

void read_faces(PlyElements& ply,
                const PlyElement& element,
                std::size_t vertices,
                TriangleMesh& mesh,
                const std::string& name) {
  PlyElements::Wanted wanted{{}, element.find_list("vertex_indices")};
  if (!wanted.list) wanted.list = element.find_list("vertex_index");
  require(wanted.list.has_value(), name + ": its faces have no list vertex_indices");
  mesh.triangles.reserve(element.count);
  ply.read_next(wanted, [&](std::span<const double>, std::span<const double> corners) {
    for (const double corner : corners) {
      if (!(corner >= 0.0 && corner < static_cast<double>(vertices))) {
        throw std::invalid_argument(name + ": a face refers to a vertex that does not exist");
      }
    }
    for (std::size_t i = 2; i < corners.size(); ++i) {
      mesh.triangles.push_back({static_cast<uint32_t>(corners[0]),
                                static_cast<uint32_t>(corners[i - 1]),
                                static_cast<uint32_t>(corners[i])});
    }
  });
}

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
  const std::string name = path.string();
  PlyElements ply(content, name);
  const auto vertex = std::find_if(ply.elements().begin(), ply.elements().end(),
                                   [](const PlyElement& e) { return e.name == "vertex"; });
  require(vertex != ply.elements().end(), name + ": it has no vertices");
  TriangleMesh mesh;
  for (const PlyElement& element : ply.elements()) {
    if (&element == &*vertex) {
      read_vertices(ply, element, mesh, name);
    } else if (element.name == "face") {
      read_faces(ply, element, vertex->count, mesh, name);
    } else {
      ply.skip_next();
    }
  }
  return mesh;
}

}  // namespace marco::files
