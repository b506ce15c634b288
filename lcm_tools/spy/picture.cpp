#include "lcm_tools/spy/picture.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/spy/picture_fields.hpp"

namespace marco::spy {
namespace {

using lcm_schema::Node;
using lcm_schema::Tree;

struct Points {
  std::vector<double> x_m;  // ahead
  std::vector<double> y_m;  // left
  std::size_t beams = 0;
};

Points scan_points(const Tree& tree) {
  Points points;
  const Node& ranges = *array(tree, "ranges");
  const Node* thetas = array(tree, "thetas");
  const double first_rad = number(tree, "rad0", 0);
  const double step_rad = number(tree, "radstep", 0);
  points.beams = ranges.count;
  for (std::size_t i = 0; i < ranges.count; ++i) {
    const double range_m = tree.number(ranges, i);
    const double bearing_rad = thetas != nullptr ? (i < thetas->count ? tree.number(*thetas, i) : 0)
                                                 : first_rad + static_cast<double>(i) * step_rad;
    if (!(range_m > 0) || !(range_m < 1e4) || !std::isfinite(bearing_rad)) continue;
    points.x_m.push_back(range_m * std::cos(bearing_rad));
    points.y_m.push_back(range_m * std::sin(bearing_rad));
  }
  return points;
}

void draw_scan(Canvas& canvas, const Tree& tree, double zoom) {
  const Points points = scan_points(tree);
  const int rows = canvas.height() - 3;
  if (points.x_m.empty()) {
    canvas.text(2, 2, "no beam of " + std::to_string(points.beams) + " has a range", Style::warn);
    return;
  }
  // Nearly all points fit: a few far ones must not make the room a dot.
  std::vector<double> reach_m;
  for (std::size_t i = 0; i < points.x_m.size(); ++i) {
    reach_m.push_back(std::max(std::abs(points.x_m[i]), std::abs(points.y_m[i])));
  }
  const auto most = reach_m.begin() + static_cast<std::ptrdiff_t>((reach_m.size() - 1) * 97 / 100);
  std::nth_element(reach_m.begin(), most, reach_m.end());
  DotGrid dots(canvas.width(), rows);
  const double middle_x = dots.width() / 2.0;
  const double middle_y = dots.height() / 2.0;
  const double dots_per_m = zoom * 0.95 * std::min(middle_x, middle_y) / std::max(*most, 0.1);
  for (std::size_t i = 0; i < points.x_m.size(); ++i) {
    const double x = middle_x - points.y_m[i] * dots_per_m;
    const double y = middle_y - points.x_m[i] * dots_per_m;
    if (std::abs(x) < 1e6 && std::abs(y) < 1e6)
      dots.dot(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)));
  }
  dots.draw(canvas, 0, 1, Style::good);
  canvas.put(canvas.width() / 2, 1 + rows / 2, U'▲', Style::warn);
  draw_scale(canvas, dots_per_m);
  canvas.text_right(canvas.width(), canvas.height() - 2,
                    std::to_string(points.x_m.size()) + " of " + std::to_string(points.beams) +
                        " beams, ahead is up",
                    Style::dim);
}

}  // namespace

PictureKind picture_kind(const Tree& tree) {
  if (array(tree, "ranges") != nullptr &&
      (array(tree, "thetas") != nullptr || field(tree, "radstep") != nullptr)) {
    return PictureKind::scan;
  }
  const bool sized = field(tree, "width", Match::with_prefix) != nullptr &&
                     field(tree, "height", Match::with_prefix) != nullptr;
  if (sized && (array(tree, "occupancy") != nullptr || array(tree, "cells") != nullptr))
    return PictureKind::grid;
  if (sized && field(tree, "pixelformat") != nullptr && array(tree, "data") != nullptr)
    return PictureKind::image;
  return PictureKind::none;
}

void draw_picture(Canvas& canvas, std::span<const Tree> messages, double zoom) {
  if (canvas.height() < 5 || messages.empty()) return;
  switch (picture_kind(messages[0])) {
    case PictureKind::scan:
      return draw_scan(canvas, messages[0], zoom);
    case PictureKind::grid:
      return draw_grid(canvas, messages, zoom);
    case PictureKind::image:
      return draw_image(canvas, messages[0], zoom);
    case PictureKind::none:
      canvas.text(2, 2, "no scan, grid or image: nothing to draw", Style::warn);
  }
}

bool same_map_other_tile(const Tree& tile, const Tree& other) {
  const Node* revision = field(tile, "revision");
  const Node* other_revision = field(other, "revision");
  if (revision == nullptr || other_revision == nullptr || picture_kind(other) != PictureKind::grid)
    return false;
  const auto place = [](const Tree& tree) {
    return std::pair{number(tree, "origin_x", 0), number(tree, "origin_y", 0)};
  };
  return tile.integer(*revision) == other.integer(*other_revision) && place(tile) != place(other);
}

}  // namespace marco::spy
