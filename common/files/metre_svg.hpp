#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace marco::files {

/// A drawing in metres as an SVG picture: x to the right, y up, 40 px per metre, on a grey grid of
/// 1 m.
class MetreSvg {
 public:
  using Points = std::vector<Eigen::Vector2d>;

  /// @param in_view  the picture is half a metre larger than these, on whole metres; 1 m if empty.
  /// @param style    CSS of what is drawn
  MetreSvg(const Points& in_view, const std::string& style);

  /// @param attributes  class="wall" and the like
  void line(const std::string& attributes, const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  void polyline(const Points& points, const std::string& attributes = "");
  void circle(const std::string& attributes, const Eigen::Vector2d& middle, double radius_m);
  /// Centred at a point; in the style of `text`. @param plain  without <, > and &
  void text(const Eigen::Vector2d& middle, const std::string& plain);
  std::string finish() { return svg_ + "</svg>\n"; }

 private:
  std::string svg_;
};

}  // namespace marco::files
