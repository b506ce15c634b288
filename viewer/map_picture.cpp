#include "viewer/map_picture.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/check.hpp"
#include "viewer/canvas.hpp"

namespace marco::viewer {
namespace {

constexpr Rgb kFrameColor{150, 155, 162};
constexpr Rgb kGridlineColor{232, 235, 239};
constexpr double kAxisMarginPx = 58.0;
constexpr double kOuterMarginPx = 22.0;

struct LegendEntry {
  std::string label;
  Rgb color;
};

Rgb cell_color(uint8_t percent) {
  if (percent == GridMap::kUnknown) return palette::kUnknown;
  const double part = std::min<double>(percent, 100.0) / 100.0;
  const auto blend = [part](uint8_t free, uint8_t occupied) {
    return static_cast<uint8_t>(std::lround(free + part * (occupied - free)));
  };
  return {blend(palette::kFree.red, palette::kOccupied.red),
          blend(palette::kFree.green, palette::kOccupied.green),
          blend(palette::kFree.blue, palette::kOccupied.blue)};
}

// The cells of the drawn area, one a pixel, north up; beyond the grid nothing is known.
Picture cells_picture(const GridMap& grid,
                      const Eigen::Vector2i& min_cell,
                      const Eigen::Vector2i& size) {
  Picture picture(size.x(), size.y(), palette::kUnknown);
  for (int y = 0; y < size.y(); ++y) {
    for (int x = 0; x < size.x(); ++x) {
      const int cell_x = min_cell.x() + x, cell_y = min_cell.y() + y;
      if (grid.contains(cell_x, cell_y))
        picture.at(x, size.y() - 1 - y) = cell_color(grid.at(cell_x, cell_y));
    }
  }
  return picture;
}

class MapPainter {
 public:
  MapPainter(const Scene& scene, const MapPictureOptions& options)
      : scene_(scene), options_(options), frame_(fit()), canvas_(make_canvas()) {}

  MapPicture paint() {
    paint_ground();
    for (const RaysItem& item : scene_.rays) paint_rays(item);
    for (const PointsItem& item : scene_.points)
      for (const Eigen::Vector3f& point : item.points_m)
        canvas_.fill_disc(frame_.to_px(point.head<2>().cast<double>()), options_.point_radius_px,
                          item.color);
    for (const WallItem& wall : scene_.walls)
      canvas_.draw_line(frame_.to_px(wall.from_m), frame_.to_px(wall.to_m), wall.color, 3.0);
    for (const PathItem& item : scene_.paths) paint_path(item);
    for (const EllipseItem& item : scene_.ellipses) paint_ellipse(item);
    for (const RobotItem& robot : scene_.robots) paint_robot(robot);
    paint_margins();
    paint_axes();
    paint_footer();
    return {canvas_.finish(), frame_};
  }

 private:
  // Odometry can run far off the map; it is followed for a fifth of the map's size, so that the
  // map itself stays readable.
  Box box_to_draw() const {
    Box all = bounding_box(scene_);
    if (!scene_.grid) return all;
    Scene grid_only;
    grid_only.grid = scene_.grid;
    const Box known = bounding_box(grid_only);
    if (known.empty()) return all;
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(0.2 * known.size_m().maxCoeff());
    return {all.min_m.cwiseMax(known.min_m - reach), all.max_m.cwiseMin(known.max_m + reach)};
  }

  // The drawn area snaps to whole cells, so that the grid is pasted without shift.
  MapFrame fit() const {
    const Box box = box_to_draw();
    require(!box.empty(), "nothing to draw: the map has no known cell, no point and no path");
    MapFrame frame;
    const Eigen::Vector2d margin = Eigen::Vector2d::Constant(options_.margin_m);
    frame.min_m = box.min_m.head<2>() - margin;
    frame.max_m = box.max_m.head<2>() + margin;
    double long_side_px = options_.long_side_px;
    if (scene_.grid) {
      const Eigen::Vector2d origin = scene_.grid->origin_m;
      const double cell = scene_.grid->resolution_m;
      frame.min_m = origin + cell * ((frame.min_m - origin) / cell).array().floor().matrix();
      frame.max_m = origin + cell * ((frame.max_m - origin) / cell).array().ceil().matrix();
    }
    const Eigen::Vector2d size = (frame.max_m - frame.min_m).cwiseMax(1e-3);
    frame.max_m = frame.min_m + size;
    frame.px_per_m = long_side_px / size.maxCoeff();
    if (scene_.grid) frame.px_per_m = whole_cells(frame.px_per_m);
    frame.corner_px = {kAxisMarginPx, kOuterMarginPx};
    return frame;
  }

  // Cells an odd number of pixels wide here and there look like noise: take whole pixels a cell
  // where cells are that large.
  double whole_cells(double px_per_m) const {
    const double px_per_cell = px_per_m * scene_.grid->resolution_m;
    if (px_per_cell < 2.0) return px_per_m;
    return std::floor(px_per_cell) / scene_.grid->resolution_m;
  }

  Eigen::Vector2d area_px() const { return frame_.px_per_m * (frame_.max_m - frame_.min_m); }
  Eigen::Vector2d far_corner_px() const { return frame_.corner_px + area_px(); }

  std::vector<LegendEntry> legend() const {
    std::vector<LegendEntry> entries;
    for (const PathItem& item : scene_.paths)
      if (!item.label.empty()) entries.push_back({item.label, item.color});
    for (const PointsItem& item : scene_.points)
      if (!item.label.empty()) entries.push_back({item.label, item.color});
    return entries;
  }

  double entry_width_px(const LegendEntry& entry) const {
    return 40.0 + Canvas::text_width_px(entry.label, options_.text_height_px) + 26.0;
  }
  double line_height_px() const { return 2.2 * options_.text_height_px; }
  double bar_length_m() const {
    return round_length(std::max(area_px().x(), 300.0) / 5.0 / frame_.px_per_m);
  }
  // Of the bar with its label.
  double bar_block_px() const {
    return bar_length_m() * frame_.px_per_m + 14.0 +
           Canvas::text_width_px(length_label(bar_length_m()), options_.text_height_px) + 40.0;
  }

  // Legend entries flow over as many lines as they need beside the scale bar.
  int footer_lines(double width_px) const {
    double x = bar_block_px();
    int lines = 1;
    for (const LegendEntry& entry : legend()) {
      const double entry_width = entry_width_px(entry);
      if (x + entry_width > width_px && x > 0.0) {
        ++lines;
        x = 0.0;
      }
      x += entry_width;
    }
    return lines;
  }

  double picture_width_px() const {
    double needed = bar_block_px();
    for (const LegendEntry& entry : legend()) needed = std::max(needed, entry_width_px(entry));
    return kAxisMarginPx + std::max(area_px().x(), needed) + kOuterMarginPx;
  }

  Canvas make_canvas() const {
    const double width = picture_width_px();
    const int lines = footer_lines(width - kAxisMarginPx - kOuterMarginPx);
    const double height =
        far_corner_px().y() + 3.2 * options_.text_height_px + lines * line_height_px() + 8.0;
    return {static_cast<int>(std::ceil(width)), static_cast<int>(std::ceil(height)),
            palette::kPaper};
  }

  void paint_ground() {
    if (!scene_.grid) return;
    const GridMap& grid = *scene_.grid;
    const Eigen::Vector2i min_cell =
        ((frame_.min_m - grid.origin_m) / grid.resolution_m).array().round().cast<int>();
    const Eigen::Vector2i size =
        ((frame_.max_m - frame_.min_m) / grid.resolution_m).array().round().cast<int>();
    canvas_.paste(cells_picture(grid, min_cell, size.cwiseMax(1)), frame_.corner_px,
                  far_corner_px());
  }

  void paint_rays(const RaysItem& item) {
    const Eigen::Vector2d origin = frame_.to_px(item.origin_m.head<2>());
    for (const Eigen::Vector3f& end : item.ends_m)
      canvas_.draw_line(origin, frame_.to_px(end.head<2>().cast<double>()), item.color, 0.5);
  }

  void paint_path(const PathItem& item) {
    const double longest_px = item.longest_step_m * frame_.px_per_m;
    std::vector<std::vector<Eigen::Vector2d>> pieces;
    for (const StampedPose2& pose : item.poses) {
      if (!is_finite(pose.world_from_robot)) continue;
      const Eigen::Vector2d point = frame_.to_px(pose.world_from_robot.translation_m());
      if (pieces.empty() || (point - pieces.back().back()).norm() > longest_px)
        pieces.emplace_back();
      pieces.back().push_back(point);
    }
    if (pieces.empty()) return;
    for (const auto& points : pieces)
      canvas_.draw_polyline(points, item.color, options_.path_width_px);
    const Eigen::Vector2d &first = pieces.front().front(), &last = pieces.back().back();
    canvas_.fill_disc(first, 2.2 * options_.path_width_px, item.color);
    canvas_.fill_disc(first, 1.2 * options_.path_width_px, palette::kPaper);
    canvas_.fill_disc(last, 2.2 * options_.path_width_px, item.color);
  }

  void paint_ellipse(const EllipseItem& item) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(item.covariance_m2);
    const Eigen::Vector2d lengths = item.sigmas * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    std::vector<Eigen::Vector2d> points;
    constexpr int kCorners = 48;
    for (int i = 0; i <= kCorners; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kCorners;
      const Eigen::Vector2d on_circle(std::cos(angle), std::sin(angle));
      points.push_back(
          frame_.to_px(item.center_m + axes.eigenvectors() * lengths.cwiseProduct(on_circle)));
    }
    canvas_.draw_polyline(points, item.color, 1.5);
  }

  void paint_robot(const RobotItem& robot) {
    std::vector<Eigen::Vector2d> points;
    constexpr int kCorners = 24;
    for (int i = 0; i <= kCorners; ++i) {
      const double bearing = std::numbers::pi * (static_cast<double>(i) / kCorners - 0.5);
      const Eigen::Vector2d in_robot(robot.radius_m * std::cos(bearing),
                                     robot.radius_m * std::sin(bearing));
      points.push_back(frame_.to_px(robot.world_from_robot * in_robot));
    }
    canvas_.fill_polygon(points, robot.color);
  }

  // What was drawn beyond the area (a path of bad odometry) is covered again.
  void paint_margins() {
    const Eigen::Vector2d low = frame_.corner_px, high = far_corner_px();
    const double width = canvas_.width_px(), height = canvas_.height_px();
    canvas_.fill_rectangle({0, 0}, {width, low.y()}, palette::kPaper);
    canvas_.fill_rectangle({0, high.y()}, {width, height}, palette::kPaper);
    canvas_.fill_rectangle({0, 0}, {low.x(), height}, palette::kPaper);
    canvas_.fill_rectangle({high.x(), 0}, {width, height}, palette::kPaper);
    const std::array<Eigen::Vector2d, 5> frame{
        {low, {high.x(), low.y()}, high, {low.x(), high.y()}, low}};
    canvas_.draw_polyline(frame, kFrameColor, 1.0);
  }

  void paint_axes() {
    const double step_m = round_length(130.0 / frame_.px_per_m);
    const Eigen::Vector2d high = far_corner_px();
    const double text = 0.8 * options_.text_height_px;
    for (const double x : ticks(frame_.min_m.x(), frame_.max_m.x(), step_m)) {
      const double px = frame_.to_px({x, frame_.min_m.y()}).x();
      canvas_.draw_line({px, high.y()}, {px, high.y() + 5.0}, kFrameColor, 1.0);
      const std::string label = tick_label(x, step_m);
      const double left = px - 0.5 * Canvas::text_width_px(label, text);
      canvas_.draw_text(label, {left, high.y() + 9.0 + 0.5 * text}, text, palette::kText);
    }
    for (const double y : ticks(frame_.min_m.y(), frame_.max_m.y(), step_m)) {
      const double px = frame_.to_px({frame_.min_m.x(), y}).y();
      canvas_.draw_line({frame_.corner_px.x() - 5.0, px}, {frame_.corner_px.x(), px}, kFrameColor,
                        1.0);
      const std::string label = tick_label(y, step_m);
      const double left = frame_.corner_px.x() - 9.0 - Canvas::text_width_px(label, text);
      canvas_.draw_text(label, {left, px}, text, palette::kText);
    }
  }

  static std::vector<double> ticks(double from_m, double to_m, double step_m) {
    std::vector<double> places;
    const auto last = static_cast<int>(std::floor(to_m / step_m));
    for (auto i = static_cast<int>(std::ceil(from_m / step_m)); i <= last; ++i)
      places.push_back(i * step_m);
    return places;
  }

  static std::string tick_label(double value_m, double step_m) {
    char text[32];
    const double rounded = std::round(value_m / step_m) * step_m;
    std::snprintf(text, sizeof text, "%g", rounded == 0.0 ? 0.0 : rounded);
    return text;
  }

  void paint_footer() {
    const double text = options_.text_height_px;
    const double right = canvas_.width_px() - kOuterMarginPx;
    Eigen::Vector2d at(kAxisMarginPx, far_corner_px().y() + 3.2 * text + 0.3 * line_height_px());
    paint_scale_bar(at);
    at.x() += bar_block_px();
    for (const LegendEntry& entry : legend()) {
      const double width = entry_width_px(entry);
      if (at.x() + width > right && at.x() > kAxisMarginPx)
        at = {kAxisMarginPx, at.y() + line_height_px()};
      canvas_.draw_line(at, at + Eigen::Vector2d(30.0, 0.0), entry.color, 4.0);
      canvas_.draw_text(entry.label, at + Eigen::Vector2d(40.0, 0.0), text, palette::kText);
      at.x() += width;
    }
  }

  void paint_scale_bar(const Eigen::Vector2d& at) {
    const double length_px = bar_length_m() * frame_.px_per_m;
    const Eigen::Vector2d half(0.0, 4.0), along(length_px, 0.0);
    canvas_.fill_rectangle(at - half, at + along + half, palette::kText);
    canvas_.fill_rectangle(at + 0.5 * along - half + Eigen::Vector2d(0.0, 1.5),
                           at + along + half - Eigen::Vector2d(1.5, 1.5), palette::kPaper);
    canvas_.draw_text(length_label(bar_length_m()), at + along + Eigen::Vector2d(14.0, 0.0),
                      options_.text_height_px, palette::kText);
  }

  const Scene& scene_;
  const MapPictureOptions& options_;
  MapFrame frame_;
  Canvas canvas_;
};

}  // namespace

double round_length(double length) {
  require(std::isfinite(length) && length > 0.0, "a length to be rounded must be above 0");
  const double decade = std::pow(10.0, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0})
    if (factor * decade <= length) return factor * decade;
  return decade;
}

std::string length_label(double length_m) {
  char text[32];
  if (length_m < 1.0)
    std::snprintf(text, sizeof text, "%.0f cm", 100.0 * length_m);
  else
    std::snprintf(text, sizeof text, "%g m", length_m);
  return text;
}

MapPicture draw_map(const Scene& scene, const MapPictureOptions& options) {
  validate(options, "map_picture");
  return MapPainter(scene, options).paint();
}

}  // namespace marco::viewer
