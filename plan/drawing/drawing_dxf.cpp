#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "common/pose2.hpp"
#include "plan/drawing/drawing.hpp"
#include "plan/drawing/dxf_entities.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

class DxfDrawer {
 public:
  explicit DxfDrawer(DxfFile file) : file_(std::move(file)) {}

  Drawing run() {
    for (const DxfEntity& entity : file_.entities) {
      draw(entity, Eigen::Affine2d::Identity(), "0", 0);
    }
    out_.drawing.unit_m = file_.unit_m;
    for (const auto& [kind, count] : file_.left_out) out_.drawing.left_out[kind] += count;
    return std::move(out_.drawing);
  }

 private:
  void draw(const DxfEntity& entity,
            const Eigen::Affine2d& drawing_from_block,
            const std::string& outer_layer,
            int depth) {
    const std::string& layer_name = entity.layer == "0" ? outer_layer : entity.layer;
    if (file_.hidden_layers.contains(layer_name)) return out_.leave_out("on a hidden layer");
    // Seen from below: what was mirrored in 3D.
    Eigen::Affine2d place = drawing_from_block;
    const bool is_flat_kind = entity.type != "LINE" && entity.type != "ELLIPSE";
    if (is_flat_kind && entity.number(230, 1.0) < 0) place = place * Eigen::Scaling(-1.0, 1.0);
    if (entity.type == "INSERT") return insert(entity, place, layer_name, depth);
    layer_ = out_.layer(layer_name);
    out_.begin_shape();
    if (entity.type == "LINE") {
      out_.line(place * entity.point(10), place * entity.point(11), layer_);
    } else if (entity.type == "LWPOLYLINE" || entity.type == "POLYLINE") {
      constexpr int kMesh = 16 | 64;
      if (entity.type == "POLYLINE" && entity.has_flag(kMesh)) return out_.leave_out("mesh");
      polyline(entity, place);
    } else if (entity.type == "CIRCLE" || entity.type == "ARC") {
      const double from = entity.type == "ARC" ? deg_to_rad(entity.number(50)) : 0.0;
      double to = entity.type == "ARC" ? deg_to_rad(entity.number(51)) : 2 * std::numbers::pi;
      to = from + turn(to - from);
      const double radius = entity.number(40);
      curve(place, entity.point(10), {radius, 0}, {0, radius}, from, to);
    } else if (entity.type == "ELLIPSE") {
      const Vector major = entity.point(11),
                   minor = entity.number(40) * Vector(-major.y(), major.x());
      const double from = entity.number(41), to = entity.number(42, 2 * std::numbers::pi);
      curve(place, entity.point(10), major, minor, from, from + turn(to - from));
    } else {
      out_.leave_out(entity.type.substr(0, 40));
    }
  }

  // In (0, 2 pi].
  static double turn(double span) {
    constexpr double kWhole = 2 * std::numbers::pi;
    require(std::abs(span) < 1e6, "contains an impossible angle");
    span = std::fmod(span, kWhole);
    return span <= 1e-9 ? span + kWhole : span;
  }

  void curve(const Eigen::Affine2d& place,
             const Vector& centre,
             const Vector& a,
             const Vector& b,
             double from,
             double to) {
    const int chords = chords_of_span(to - from);
    const auto at = [&](int i) -> Vector {
      const double angle = from + (to - from) * i / chords;
      return place * Vector(centre + a * std::cos(angle) + b * std::sin(angle));
    };
    for (int i = 0; i < chords; ++i) out_.line(at(i), at(i + 1), layer_, true);
  }

  void polyline(const DxfEntity& entity, const Eigen::Affine2d& place) {
    const std::vector<DxfEntity::Corner>& corners = entity.corners;
    const std::size_t count = corners.size();
    for (std::size_t i = 0; i + (entity.has_flag(1) ? 0 : 1) < count; ++i) {
      const Vector a = corners[i].at, b = corners[(i + 1) % count].at;
      const double bulge = corners[i].bulge;
      if (std::abs(bulge) < 1e-9 || a == b) {
        out_.line(place * a, place * b, layer_);
        continue;
      }
      const Vector chord = b - a, left(-chord.y(), chord.x());
      const Vector centre = (a + b) / 2 + left * (1 - bulge * bulge) / (4 * bulge);
      const Vector start = a - centre;
      curve(place, centre, start, {-start.y(), start.x()}, 0.0, 4 * std::atan(bulge));
    }
  }

  void insert(const DxfEntity& entity,
              const Eigen::Affine2d& place,
              const std::string& layer,
              int depth) {
    constexpr int kDeepest = 16;
    constexpr std::size_t kMostDrawn = 300'000;
    const auto block = file_.blocks.find(entity.name);
    if (block == file_.blocks.end()) return out_.leave_out("INSERT of a missing block");
    if (block->second.entities.empty()) return;
    require(depth < kDeepest, "nests blocks more than 16 deep");
    const auto copies = [&](int code) {
      const double count = entity.number(code, 1.0);
      require(count >= 0 && count <= 1e5, "inserts a block more than 100000 times");
      return std::max(1, static_cast<int>(count));
    };
    const int columns = copies(70), rows = copies(71);
    const Eigen::Affine2d turned = place * Eigen::Translation2d(entity.point(10)) *
                                   Eigen::Rotation2Dd(deg_to_rad(entity.number(50)));
    const Eigen::Affine2d scaled = Eigen::Scaling(entity.number(41, 1.0), entity.number(42, 1.0)) *
                                   Eigen::Translation2d(-block->second.base);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        drawn_ += 1 + block->second.entities.size();
        require(drawn_ < kMostDrawn, "inserts blocks endlessly");
        const Vector step(column * entity.number(44), row * entity.number(45));
        const Eigen::Affine2d inside = turned * Eigen::Translation2d(step) * scaled;
        for (const DxfEntity& part : block->second.entities) draw(part, inside, layer, depth + 1);
      }
    }
  }

  DxfFile file_;
  DrawingBuilder out_;
  int layer_ = 0;
  std::size_t drawn_ = 0;
};

}  // namespace

Drawing read_dxf(const std::string& text) { return DxfDrawer(parse_dxf(text)).run(); }

}  // namespace marco::plan
