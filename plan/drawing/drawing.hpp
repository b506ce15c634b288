#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lcm_tools/base/check.hpp"

namespace marco::plan {

/// A straight line of a drawing, or a chord of one of its curves.
struct DrawnLine {
  Eigen::Vector2d from = {0, 0};  ///< drawing units; x to the right, y up
  Eigen::Vector2d to = {0, 0};
  int layer = 0;        ///< of Drawing::layers
  int shape = 0;        ///< lines drawn as one (a polyline, a circle) share it
  bool curved = false;  ///< a chord
};

/// A plan that somebody drew, as its lines. Curves are chains of chords of 2.5 degrees at most,
/// which leave a circle of 5 m radius by 1.2 mm.
struct Drawing {
  std::vector<std::string> layers;  ///< printable names
  std::vector<DrawnLine> lines;
  std::optional<double> unit_m;        ///< metres of building a unit, where the file says so
  std::optional<double> paper_unit_m;  ///< metres of paper a unit, where it has a size on paper
  /// What was not taken, by kind ("TEXT", "on a hidden layer") and number.
  std::map<std::string, int> left_out;
};

/// Collects a drawing's lines, within bounds that no plan reaches and a hostile file does.
class DrawingBuilder {
 public:
  static constexpr std::size_t kMostLines = 2'000'000;
  static constexpr double kFarthest = 1e9;  ///< units

  /// The index of a layer, which is made where it is new. Bytes that do not print become "?".
  int layer(const std::string& name);
  /// What follows is another shape.
  void begin_shape() { ++shape_; }
  /// @throws std::invalid_argument beyond the bounds. Points that coincide make no line.
  void line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, int layer, bool curved = false);
  void leave_out(const std::string& kind) { ++drawing.left_out[kind]; }

  Drawing drawing;

 private:
  std::map<std::string, int> index_;
  int shape_ = 0;
};

/// Chords of a span.
int chords_of_span(double span_rad);

/// @throws std::invalid_argument saying what is wrong, to be put behind the file's name.
/// DXF as text, of any release: LINE, LWPOLYLINE, POLYLINE, ARC, CIRCLE, ELLIPSE, and INSERT of
/// blocks to any depth up to 16. What lies on hidden layers or on paper space is left out.
Drawing read_dxf(const std::string& text);
/// SVG: line, polyline, polygon, rect, circle, ellipse and path below any transform. The layer of a
/// shape is its class, else the Inkscape layer or the named group that it lies in. A root with
/// `data-metres-per-unit` (our own drawings) says the building's scale, one with a width in mm, cm,
/// in or pt the paper's.
Drawing read_svg(const std::string& text);
/// By content: DXF or SVG. @throws as these, and for what is neither.
Drawing read_drawing(const std::string& text);

}  // namespace marco::plan
