#pragma once

#include <string>
#include <vector>

#include "viewer/canvas.hpp"

namespace marco::viewer {

/// Maps the world into a map picture: north (y) up, east (x) right.
struct MapFrame {
  Eigen::Vector2d min_m = Eigen::Vector2d::Zero();  ///< world at the drawn area's lower left
  Eigen::Vector2d max_m = Eigen::Vector2d::Zero();
  double px_per_m = 1.0;
  Eigen::Vector2d corner_px = Eigen::Vector2d::Zero();  ///< upper left of the drawn area

  Eigen::Vector2d to_px(const Eigen::Vector2d& point_m) const {
    return corner_px + px_per_m * Eigen::Vector2d(point_m.x() - min_m.x(), max_m.y() - point_m.y());
  }
  Eigen::Vector2d far_corner_px() const { return corner_px + px_per_m * (max_m - min_m); }
};

struct LegendEntry {
  std::string label;
  Rgb color;
};

/// The border of a map picture: axes in metres, a scale bar and a legend on as many lines as it
/// needs.
class MapBorder {
 public:
  static constexpr double kAxisMarginPx = 58.0;   ///< left of the drawn area
  static constexpr double kOuterMarginPx = 22.0;  ///< above it and right of it

  /// @param text_height_px of a capital.
  MapBorder(const MapFrame& frame, std::vector<LegendEntry> legend, double text_height_px);

  /// Of the drawn area and its border.
  int picture_width_px() const;
  int picture_height_px() const;

  /// Clears everything drawn outside the area (a path of bad odometry), then paints. @param canvas
  /// of the picture's size.
  void paint(Canvas& canvas) const;

 private:
  double entry_width_px(const LegendEntry& entry) const;
  double line_height_px() const { return 2.2 * text_height_px_; }
  double scale_bar_px() const;
  int footer_lines() const;
  void paint_margins(Canvas& canvas) const;
  void paint_axes(Canvas& canvas) const;
  void paint_footer(Canvas& canvas) const;
  void paint_scale_bar(Canvas& canvas, const Eigen::Vector2d& at) const;

  MapFrame frame_;
  std::vector<LegendEntry> legend_;
  double text_height_px_;
  double bar_length_m_;
};

/// 1, 2 or 5 times a power of ten, the largest one not above `length`. @param length > 0.
double round_length(double length);

/// "5 m", "20 cm".
std::string length_label(double length_m);

}  // namespace marco::viewer
