#include "viewer/painted_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "viewer/image_io.hpp"

namespace marco::viewer {
namespace {

struct Corner {
  Eigen::Vector3f at_m;
  Eigen::Vector2f uv;
};

class Painter {
 public:
  Painter(const Picture& picture, double step_m)
      : picture_(picture), step2_m2_(static_cast<float>(step_m * step_m)) {}

  void add(const Corner& a, const Corner& b, const Corner& c) {
    const float ab = (a.at_m - b.at_m).squaredNorm(), bc = (b.at_m - c.at_m).squaredNorm(),
                ca = (c.at_m - a.at_m).squaredNorm();
    if (std::max({ab, bc, ca}) <= step2_m2_) {
      emit(a, b, c);
    } else if (ab >= bc && ab >= ca) {
      halve(a, b, c);
    } else if (bc >= ca) {
      halve(b, c, a);
    } else {
      halve(c, a, b);
    }
  }
  TriangleMesh take() { return std::move(mesh_); }

 private:
  void halve(const Corner& a, const Corner& b, const Corner& c) {
    const Corner middle{0.5F * (a.at_m + b.at_m), 0.5F * (a.uv + b.uv)};
    add(a, middle, c);
    add(middle, b, c);
  }
  void emit(const Corner& a, const Corner& b, const Corner& c) {
    const auto first = static_cast<uint32_t>(mesh_.vertices_m.size());
    mesh_.triangles.push_back({first, first + 1, first + 2});
    for (const Corner& corner : {a, b, c}) {
      mesh_.vertices_m.push_back(corner.at_m);
      mesh_.colors_rgb.push_back(colour(corner.uv));
    }
  }
  std::array<uint8_t, 3> colour(const Eigen::Vector2f& uv) const {
    const auto place = [](float part, int size_px) {
      const float at = std::clamp(part, 0.0F, 1.0F) * static_cast<float>(size_px);
      return static_cast<std::size_t>(std::min(static_cast<int>(at), size_px - 1));
    };
    const Rgb& pixel = picture_.pixels[place(uv.y(), picture_.height_px) *
                                           static_cast<std::size_t>(picture_.width_px) +
                                       place(uv.x(), picture_.width_px)];
    return {pixel.red, pixel.green, pixel.blue};
  }

  const Picture& picture_;
  float step2_m2_;
  TriangleMesh mesh_;
};

// The longest edges a mesh may keep without becoming more triangles than a computer holds: those of
// a building, not of a room.
double step_for(const TriangleMesh& mesh, double step_m, double most_triangles) {
  // Halving the longest edge leaves right triangles of an eighth of the step squared; of a sliver
  // it makes three of half the length.
  const double power = std::log2(3.0);
  double area_m2 = 0.0, slivers = 0.0;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices_m[triangle[0]].cast<double>();
    const Eigen::Vector3d ab = mesh.vertices_m[triangle[1]].cast<double>() - a;
    const Eigen::Vector3d ac = mesh.vertices_m[triangle[2]].cast<double>() - a;
    area_m2 += 0.5 * ab.cross(ac).norm();
    slivers += std::pow(2.0 * std::max({ab.norm(), ac.norm(), (ac - ab).norm()}), power);
  }
  const auto triangles = [&] {
    return 8.0 * area_m2 / (step_m * step_m) + slivers / std::pow(step_m, power);
  };
  while (triangles() > most_triangles) step_m *= 1.2;
  return step_m;
}

}  // namespace

TriangleMesh with_painted_vertices(const TexturedMesh& textured,
                                   double step_m,
                                   double most_triangles) {
  require(step_m > 0.0 && most_triangles >= 1.0,
          "with_painted_vertices: step_m and most_triangles must be > 0");
  if (textured.uvs.empty() || textured.image.empty()) return textured.mesh;
  const Picture picture = decode_picture(textured.image);
  Painter painter(picture, step_for(textured.mesh, step_m, most_triangles));
  for (const auto& triangle : textured.mesh.triangles) {
    std::array<Corner, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = {textured.mesh.vertices_m[triangle[i]], textured.uvs[triangle[i]]};
    }
    painter.add(corners[0], corners[1], corners[2]);
  }
  return painter.take();
}

}  // namespace marco::viewer
