#include "viewer/map_picture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lcm_tools/base/check.hpp"
#include "viewer/canvas.hpp"
#include "viewer/map_border.hpp"
#include "viewer/map_extent.hpp"

namespace marco::viewer {
namespace {

Rgb blend(Rgb from, Rgb to, double part) {
  const auto mix = [part](uint8_t a, uint8_t b) {
    return static_cast<uint8_t>(std::lround(a + part * (b - a)));
  };
  return {mix(from.red, to.red), mix(from.green, to.green), mix(from.blue, to.blue)};
}

// From white (free) over grey (unknown) to black (occupied). The bends set cells that were seen
// only once clearly apart from unknown ones.
Rgb cell_color(uint8_t percent) {
  constexpr double kFreeBend = 3.0, kOccupiedBend = 0.6;
  if (percent == GridMap::kUnknown) return palette::kUnknown;
  const double off_middle = std::min<double>(percent, 100.0) / 50.0 - 1.0;
  if (off_middle <= 0.0)
    return blend(palette::kFree, palette::kUnknown, std::pow(1.0 + off_middle, kFreeBend));
  return blend(palette::kUnknown, palette::kOccupied, std::pow(off_middle, kOccupiedBend));
}

// The cells of the drawn area, one per pixel, north up; unknown beyond the grid.
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

std::optional<MapExtent> extent_of(const Scene& scene) {
  return scene.grid ? find_extent(*scene.grid) : std::nullopt;
}

std::vector<LegendEntry> legend_of(const Scene& scene, const std::optional<MapExtent>& extent) {
  std::vector<LegendEntry> entries;
  for (const PathItem& item : scene.paths)
    if (!item.label.empty()) entries.push_back({item.label, item.color});
  for (const PointsItem& item : scene.points)
    if (!item.label.empty()) entries.push_back({item.label, item.color});
  if (extent && extent->cells_beyond > 0)
    entries.push_back(
        {std::to_string(extent->cells_beyond) + " cells seen by single beams are outside",
         palette::kUnknown});
  return entries;
}

class MapPainter {
 public:
  MapPainter(const Scene& scene, const MapPictureOptions& options)
      : scene_(scene),
        options_(options),
        extent_(extent_of(scene)),
        frame_(fit()),
        border_(frame_, legend_of(scene, extent_), options.text_height_px),
        canvas_(border_.picture_width_px(), border_.picture_height_px(), palette::kPaper) {}

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
    border_.paint(canvas_);
    return {canvas_.finish(), frame_};
  }

 private:
  // Odometry may leave the map: the picture grows by at most a fifth of the map's size for it.
  Box box_to_draw() const {
    if (!extent_) return bounding_box(scene_);
    Box known;
    known.add((Eigen::Vector3d() << extent_->min_m(*scene_.grid), 0.0).finished());
    known.add((Eigen::Vector3d() << extent_->max_m(*scene_.grid), 0.0).finished());
    Scene others = scene_;
    others.grid.reset();
    others.points.clear();
    const Box around = bounding_box(others);
    if (around.empty()) return known;
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(0.2 * known.size_m().maxCoeff());
    return {known.min_m.cwiseMin(around.min_m.cwiseMax(known.min_m - reach)),
            known.max_m.cwiseMax(around.max_m.cwiseMin(known.max_m + reach))};
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
    frame.corner_px = {MapBorder::kAxisMarginPx, MapBorder::kOuterMarginPx};
    return frame;
  }

  // Cells an odd number of pixels wide here and there look like noise: take whole pixels a cell
  // where cells are that large.
  double whole_cells(double px_per_m) const {
    const double px_per_cell = px_per_m * scene_.grid->resolution_m;
    if (px_per_cell < 2.0) return px_per_m;
    return std::floor(px_per_cell) / scene_.grid->resolution_m;
  }

  void paint_ground() {
    if (!scene_.grid) return;
    const GridMap& grid = *scene_.grid;
    const Eigen::Vector2i min_cell =
        ((frame_.min_m - grid.origin_m) / grid.resolution_m).array().round().cast<int>();
    const Eigen::Vector2i size =
        ((frame_.max_m - frame_.min_m) / grid.resolution_m).array().round().cast<int>();
    canvas_.paste(cells_picture(grid, min_cell, size.cwiseMax(1)), frame_.corner_px,
                  frame_.far_corner_px());
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
    std::vector<Eigen::Vector2d> points;
    for (const Eigen::Vector2d& corner_m : item.outline_m()) {
      points.push_back(frame_.to_px(corner_m));
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

  const Scene& scene_;
  const MapPictureOptions& options_;
  std::optional<MapExtent> extent_;
  MapFrame frame_;
  MapBorder border_;
  Canvas canvas_;
};

}  // namespace

MapPicture draw_map(const Scene& scene, const MapPictureOptions& options) {
  validate(options, "map_picture");
  return MapPainter(scene, options).paint();
}

}  // namespace marco::viewer
