#include "common/files/obj.hpp"

#include <array>
#include <cstdio>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {

void write_obj(const std::filesystem::path& path, const TriangleMesh& mesh) {
  const bool normals = !mesh.normals.empty(), colors = !mesh.colors_rgb.empty();
  require((!normals || mesh.normals.size() == mesh.vertices_m.size()) &&
              (!colors || mesh.colors_rgb.size() == mesh.vertices_m.size()),
          "write_obj: expected one normal and colour per vertex, or none");
  std::string text = "# metres, x forward, y left, z up\n";
  std::array<char, 160> line{};
  const auto add = [&](int length) { text.append(line.data(), static_cast<std::size_t>(length)); };
  const auto wide = [](float value) { return static_cast<double>(value); };
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    const Eigen::Vector3f& v = mesh.vertices_m[i];
    add(std::snprintf(line.data(), line.size(), "v %.4f %.4f %.4f", wide(v.x()), wide(v.y()),
                      wide(v.z())));
    if (colors) {
      const auto& c = mesh.colors_rgb[i];
      add(std::snprintf(line.data(), line.size(), " %.3f %.3f %.3f", c[0] / 255.0, c[1] / 255.0,
                        c[2] / 255.0));
    }
    text += '\n';
  }
  for (const Eigen::Vector3f& n : mesh.normals) {
    add(std::snprintf(line.data(), line.size(), "vn %.3f %.3f %.3f\n", wide(n.x()), wide(n.y()),
                      wide(n.z())));
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    const char* format = normals ? "f %u//%u %u//%u %u//%u\n" : "f %u %u %u\n";
    if (normals) {
      add(std::snprintf(line.data(), line.size(), format, a + 1, a + 1, b + 1, b + 1, c + 1,
                        c + 1));
    } else {
      add(std::snprintf(line.data(), line.size(), format, a + 1, b + 1, c + 1));
    }
  }
  write_whole_file(path, text);
}

}  // namespace marco::files
