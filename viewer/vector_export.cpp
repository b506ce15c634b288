#include "viewer/vector_export.hpp"

#include <gl2ps.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>
#include <stdexcept>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "viewer/scene_geometry.hpp"
#include "viewer/shading.hpp"

namespace marco::viewer {
namespace {

using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;

Vector3d position_of(const Vertex& vertex) {
  return Eigen::Map<const Eigen::Vector3f>(vertex.position_m.data()).cast<double>();
}
Vector3d color_of(const Vertex& vertex) {
  return Vector3d(vertex.color[0], vertex.color[1], vertex.color[2]) / 255.0;
}

// The part of a convex polygon where `distance` is not negative (Sutherland and Hodgman).
template <class Distance>
Polygon clip(const Polygon& polygon, Distance distance) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double at_a = distance(a), at_b = distance(b);
    if (at_a >= 0.0) kept.push_back(a);
    if ((at_a >= 0.0) != (at_b >= 0.0)) kept.push_back(a + (b - a) * (at_a / (at_a - at_b)));
  }
  return kept;
}

class VectorPage {
 public:
  VectorPage(const Scene& scene, const ViewPlan& plan, PictureSize size)
      : camera_(plan.camera),
        look_(plan.look),
        size_(size),
        from_world_(camera_from_world(plan.camera)),
        clip_(clip_from_camera(plan.camera, size.aspect()) * from_world_),
        lamp_direction_(from_world_.topLeftCorner<3, 3>().transpose() * lamp_in_camera()),
        geometry_(build_geometry(scene)),
        heights_m_(height_range_m(plan.look, bounding_box(scene))) {}

  VectorReport add() {
    add_paper();
    add_triangles(geometry_.props, Coloring::scene, 1e30, Mode::filled);
    if (look_.mode == Mode::points)
      for (const Vertex& vertex : geometry_.surfaces.vertices)
        add_point(vertex, base_color(vertex, position_of(vertex), look_.coloring));
    else
      add_triangles(geometry_.surfaces, look_.coloring, look_.cut_height_m, look_.mode);
    for (const Vertex& vertex : geometry_.points.vertices) add_point(vertex, color_of(vertex));
    for (std::size_t i = 0; i + 1 < geometry_.lines.vertices.size(); i += 2)
      add_line(position_of(geometry_.lines.vertices[i]),
               position_of(geometry_.lines.vertices[i + 1]), color_of(geometry_.lines.vertices[i]));
    return report_;
  }

 private:
  // gl2ps would ask the OpenGL context that is not there for its background.
  void add_paper() {
    const Rgb paper = look_.background;
    const auto corner = [&](int x, int y) {
      GL2PSvertex result{};
      result.xyz[0] = static_cast<GLfloat>(x);
      result.xyz[1] = static_cast<GLfloat>(y);
      result.xyz[2] = 1e30F;
      result.rgba[0] = static_cast<GLfloat>(paper.red) / 255.0F;
      result.rgba[1] = static_cast<GLfloat>(paper.green) / 255.0F;
      result.rgba[2] = static_cast<GLfloat>(paper.blue) / 255.0F;
      result.rgba[3] = 1.0F;
      return result;
    };
    std::array<GL2PSvertex, 3> lower{corner(0, 0), corner(size_.width_px, 0),
                                     corner(size_.width_px, size_.height_px)};
    std::array<GL2PSvertex, 3> upper{corner(0, 0), corner(size_.width_px, size_.height_px),
                                     corner(0, size_.height_px)};
    hand_over(GL2PS_TRIANGLE, lower.data(), 3, 1.0F);
    hand_over(GL2PS_TRIANGLE, upper.data(), 3, 1.0F);
  }

  void add_triangles(const Geometry& part, Coloring coloring, double cut_m, Mode mode) {
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      const Vertex& first = part.vertices[part.indices[i]];
      const Polygon triangle{position_of(first), position_of(part.vertices[part.indices[i + 1]]),
                             position_of(part.vertices[part.indices[i + 2]])};
      const bool hides_back = look_.back_faces != BackFaces::show && &part == &geometry_.surfaces;
      add_triangle(triangle, base_color(first, middle(triangle), coloring),
                   {cut_m, hides_back, mode});
    }
  }

  struct Rules {
    double cut_height_m;
    bool hides_back;
    Mode mode;
  };

  void add_triangle(const Polygon& triangle, const Vector3d& base, const Rules& rules) {
    Vector3d normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    if (normal.norm() <= 0.0) return;
    normal.normalize();
    const Vector3d towards_eye = to_eye(middle(triangle));
    if (normal.dot(towards_eye) < 0.0) {
      if (rules.hides_back) return;
      normal = -normal;
    }
    Polygon seen = clip(triangle, [&](const Vector3d& p) { return rules.cut_height_m - p.z(); });
    seen = clip(seen, [&](const Vector3d& p) { return depth_of(p) - camera_.near_m; });
    if (seen.size() < 3 || outside(seen)) return;
    const Vector3d color = base * light(normal, middle(triangle));
    if (rules.mode == Mode::wire) {
      for (std::size_t i = 0; i < seen.size(); ++i)
        add_line(seen[i], seen[(i + 1) % seen.size()], color);
      return;
    }
    for (std::size_t i = 2; i < seen.size(); ++i) {
      std::array<GL2PSvertex, 3> corners{vertex(seen[0], color), vertex(seen[i - 1], color),
                                         vertex(seen[i], color)};
      hand_over(GL2PS_TRIANGLE, corners.data(), 3, 1.0F);
      ++report_.polygons;
    }
  }

  void add_line(const Vector3d& from, const Vector3d& to, const Vector3d& color) {
    if (depth_of(from) < camera_.near_m || depth_of(to) < camera_.near_m) return;
    std::array<GL2PSvertex, 2> ends{vertex(from, color), vertex(to, color)};
    hand_over(GL2PS_LINE, ends.data(), 2, 0.4F);
    ++report_.lines;
  }

  void add_point(const Vertex& at, const Vector3d& color) {
    const Vector3d place = position_of(at);
    if (!place.allFinite() || place.z() > look_.cut_height_m || outside({place})) return;
    if (depth_of(place) < camera_.near_m) return;
    GL2PSvertex dot = vertex(place, color);
    hand_over(GL2PS_POINT, &dot, 1, static_cast<float>(look_.point_size_px));
  }

  static void hand_over(GLshort type, GL2PSvertex* vertices, GLshort count, float width) {
    gl2psAddPolyPrimitive(type, count, vertices, 0, 0.0F, 0.0F, 0xFFFF, 1, width, 0, 0, 0);
  }

  GL2PSvertex vertex(const Vector3d& place, const Vector3d& color) const {
    const Eigen::Vector4d clipped = clip_ * place.homogeneous();
    const Vector3d ndc = clipped.head<3>() / clipped.w();
    GL2PSvertex result{};
    result.xyz[0] = static_cast<GLfloat>(0.5 * (1.0 + ndc.x()) * size_.width_px);
    result.xyz[1] = static_cast<GLfloat>(0.5 * (1.0 + ndc.y()) * size_.height_px);
    // The distance itself: depth-buffer values crowd near 1, where floats no longer sort them.
    result.xyz[2] = static_cast<GLfloat>(depth_of(place));
    for (int i = 0; i < 3; ++i)
      result.rgba[i] = static_cast<GLfloat>(std::clamp(color[i], 0.0, 1.0));
    result.rgba[3] = 1.0F;
    return result;
  }

  Vector3d base_color(const Vertex& vertex, const Vector3d& place, Coloring coloring) const {
    switch (coloring) {
      case Coloring::height:
        return height_color((place.z() - heights_m_[0]) /
                            std::max(heights_m_[1] - heights_m_[0], 1e-3));
      case Coloring::grey:
        return Vector3d::Constant(kThesisGrey);
      case Coloring::normal:
        return Vector3d::Constant(0.5) +
               Vector3d(vertex.normal[0], vertex.normal[1], vertex.normal[2]) / 65534.0;
      case Coloring::scene:
        return color_of(vertex);
    }
    throw std::logic_error("a coloring without a rule");
  }

  double light(const Vector3d& normal, const Vector3d& place) const {
    if (look_.light == Light::thesis)
      return kThesisAmbient +
             kThesisDiffuse * std::max(normal.dot((look_.lamp_m - place).normalized()), 0.0);
    return kRoomAmbient + kRoomSky * normal.z() +
           kRoomLamp * std::max(normal.dot(lamp_direction_), 0.0);
  }

  bool outside(const Polygon& polygon) const {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e30), high = -low;
    for (const Vector3d& corner : polygon) {
      const Eigen::Vector4d clipped = clip_ * corner.homogeneous();
      low = low.cwiseMin(clipped.head<2>() / clipped.w());
      high = high.cwiseMax(clipped.head<2>() / clipped.w());
    }
    return low.maxCoeff() > 1.0 || high.minCoeff() < -1.0;
  }

  static Vector3d middle(const Polygon& triangle) {
    return (triangle[0] + triangle[1] + triangle[2]) / 3.0;
  }
  Vector3d to_eye(const Vector3d& place) const {
    if (camera_.projection == Projection::orthographic) return from_world_.row(2).head<3>();
    return camera_.eye_m - place;
  }
  double depth_of(const Vector3d& place) const {
    return -from_world_.row(2).dot(place.homogeneous());
  }

  const Camera& camera_;
  const Look& look_;
  PictureSize size_;
  Eigen::Matrix4d from_world_;
  Eigen::Matrix4d clip_;
  Vector3d lamp_direction_;
  SceneGeometry geometry_;
  std::array<double, 2> heights_m_;
  VectorReport report_;
};

GLint gl2ps_format(VectorFormat format) {
  switch (format) {
    case VectorFormat::eps:
      return GL2PS_EPS;
    case VectorFormat::svg:
      return GL2PS_SVG;
    case VectorFormat::pdf:
      return GL2PS_PDF;
  }
  throw std::logic_error("a vector format without a number");
}

}  // namespace

VectorReport write_vector(const Scene& scene,
                          const ViewPlan& plan,
                          PictureSize size,
                          VectorFormat format,
                          const std::string& path) {
  require(size.width_px > 0 && size.height_px > 0, "a page needs a size above 0");
  VectorPage page(scene, plan, size);
  char* text = nullptr;
  std::size_t text_bytes = 0;
  std::FILE* page_file = open_memstream(&text, &text_bytes);
  if (page_file == nullptr) throw std::bad_alloc();
  std::array<GLint, 4> viewport{0, 0, size.width_px, size.height_px};
  const GLint begun =
      gl2psBeginPage(path.c_str(), "Marco", viewport.data(), gl2ps_format(format),
                     GL2PS_SIMPLE_SORT, GL2PS_NO_OPENGL_CONTEXT | GL2PS_NO_BLENDING | GL2PS_SILENT,
                     GL_RGBA, 0, nullptr, 0, 0, 0, 1024, page_file, path.c_str());
  VectorReport report;
  if (begun == GL2PS_SUCCESS) {
    report = page.add();
    gl2psEndPage();
  }
  const bool whole = std::fclose(page_file) == 0;
  const std::unique_ptr<char, decltype(&std::free)> owned(text, &std::free);
  if (begun != GL2PS_SUCCESS) throw std::logic_error("gl2ps refused to begin a page");
  if (!whole) throw std::bad_alloc();
  files::write_whole_file(path, {text, text_bytes});
  return report;
}

VectorFormat vector_format(const std::string& path) {
  const auto ends_with = [&path](const char* ending) { return path.ends_with(ending); };
  if (ends_with(".eps")) return VectorFormat::eps;
  if (ends_with(".svg")) return VectorFormat::svg;
  require(ends_with(".pdf"), path + ": a vector picture ends in .eps, .svg or .pdf");
  return VectorFormat::pdf;
}

}  // namespace marco::viewer
