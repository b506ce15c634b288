#include "viewer/map_border.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::viewer {
namespace {

constexpr Rgb kFrameColor{150, 155, 162};
constexpr double kLegendLinePx = 30.0;
constexpr double kGapPx = 14.0;

std::vector<double> ticks(double from_m, double to_m, double step_m) {
  std::vector<double> places;
  const auto last = static_cast<int>(std::floor(to_m / step_m));
  for (auto i = static_cast<int>(std::ceil(from_m / step_m)); i <= last; ++i)
    places.push_back(i * step_m);
  return places;
}

std::string tick_label(double value_m, double step_m) {
  const double rounded = std::round(value_m / step_m) * step_m;
  return format("%g", rounded == 0.0 ? 0.0 : rounded);
}

}  // namespace

MapBorder::MapBorder(const MapFrame& frame, std::vector<LegendEntry> legend, double text_height_px)
    : frame_(frame), legend_(std::move(legend)), text_height_px_(text_height_px) {
  const double area_px = frame_.far_corner_px().x() - frame_.corner_px.x();
  bar_length_m_ = round_length(std::max(area_px, 300.0) / 5.0 / frame_.px_per_m);
}

double MapBorder::entry_width_px(const LegendEntry& entry) const {
  return kLegendLinePx + 10.0 + Canvas::text_width_px(entry.label, text_height_px_) + 26.0;
}

// With its label.
double MapBorder::scale_bar_px() const {
  return bar_length_m_ * frame_.px_per_m + kGapPx +
         Canvas::text_width_px(length_label(bar_length_m_), text_height_px_) + 40.0;
}

int MapBorder::picture_width_px() const {
  double footer = scale_bar_px();
  for (const LegendEntry& entry : legend_) footer = std::max(footer, entry_width_px(entry));
  const double area = frame_.far_corner_px().x() - kAxisMarginPx;
  return static_cast<int>(std::ceil(kAxisMarginPx + std::max(area, footer) + kOuterMarginPx));
}

int MapBorder::picture_height_px() const {
  return static_cast<int>(std::ceil(frame_.far_corner_px().y() + 3.2 * text_height_px_ +
                                    footer_lines() * line_height_px() + 8.0));
}

int MapBorder::footer_lines() const {
  const double width = picture_width_px() - kAxisMarginPx - kOuterMarginPx;
  double x = scale_bar_px();
  int lines = 1;
  for (const LegendEntry& entry : legend_) {
    const double entry_width = entry_width_px(entry);
    if (x + entry_width > width && x > 0.0) {
      ++lines;
      x = 0.0;
    }
    x += entry_width;
  }
  return lines;
}

void MapBorder::paint(Canvas& canvas) const {
  paint_margins(canvas);
  paint_axes(canvas);
  paint_footer(canvas);
}

void MapBorder::paint_margins(Canvas& canvas) const {
  const Eigen::Vector2d low = frame_.corner_px, high = frame_.far_corner_px();
  const double width = canvas.width_px(), height = canvas.height_px();
  canvas.fill_rectangle({0, 0}, {width, low.y()}, palette::kPaper);
  canvas.fill_rectangle({0, high.y()}, {width, height}, palette::kPaper);
  canvas.fill_rectangle({0, 0}, {low.x(), height}, palette::kPaper);
  canvas.fill_rectangle({high.x(), 0}, {width, height}, palette::kPaper);
  const std::array<Eigen::Vector2d, 5> frame{
      {low, {high.x(), low.y()}, high, {low.x(), high.y()}, low}};
  canvas.draw_polyline(frame, kFrameColor, 1.0);
}

void MapBorder::paint_axes(Canvas& canvas) const {
  const double step_m = round_length(130.0 / frame_.px_per_m);
  const Eigen::Vector2d low = frame_.corner_px, high = frame_.far_corner_px();
  const double text = 0.8 * text_height_px_;
  for (const double x : ticks(frame_.min_m.x(), frame_.max_m.x(), step_m)) {
    const double px = frame_.to_px({x, frame_.min_m.y()}).x();
    canvas.draw_line({px, high.y()}, {px, high.y() + 5.0}, kFrameColor, 1.0);
    const std::string label = tick_label(x, step_m);
    const double left = px - 0.5 * Canvas::text_width_px(label, text);
    canvas.draw_text(label, {left, high.y() + 9.0 + 0.5 * text}, text, palette::kText);
  }
  for (const double y : ticks(frame_.min_m.y(), frame_.max_m.y(), step_m)) {
    const double px = frame_.to_px({frame_.min_m.x(), y}).y();
    canvas.draw_line({low.x() - 5.0, px}, {low.x(), px}, kFrameColor, 1.0);
    const std::string label = tick_label(y, step_m);
    const double left = low.x() - 9.0 - Canvas::text_width_px(label, text);
    canvas.draw_text(label, {left, px}, text, palette::kText);
  }
}

void MapBorder::paint_footer(Canvas& canvas) const {
  const double right = canvas.width_px() - kOuterMarginPx;
  Eigen::Vector2d at(kAxisMarginPx,
                     frame_.far_corner_px().y() + 3.2 * text_height_px_ + 0.3 * line_height_px());
  paint_scale_bar(canvas, at);
  at.x() += scale_bar_px();
  for (const LegendEntry& entry : legend_) {
    const double width = entry_width_px(entry);
    if (at.x() + width > right && at.x() > kAxisMarginPx)
      at = {kAxisMarginPx, at.y() + line_height_px()};
    canvas.draw_line(at, at + Eigen::Vector2d(kLegendLinePx, 0.0), entry.color, 4.0);
    canvas.draw_text(entry.label, at + Eigen::Vector2d(kLegendLinePx + 10.0, 0.0), text_height_px_,
                     palette::kText);
    at.x() += width;
  }
}

void MapBorder::paint_scale_bar(Canvas& canvas, const Eigen::Vector2d& at) const {
  const Eigen::Vector2d half(0.0, 4.0), along(bar_length_m_ * frame_.px_per_m, 0.0);
  canvas.fill_rectangle(at - half, at + along + half, palette::kText);
  canvas.fill_rectangle(at + 0.5 * along - half + Eigen::Vector2d(0.0, 1.5),
                        at + along + half - Eigen::Vector2d(1.5, 1.5), palette::kPaper);
  canvas.draw_text(length_label(bar_length_m_), at + along + Eigen::Vector2d(kGapPx, 0.0),
                   text_height_px_, palette::kText);
}

double round_length(double length) {
  require(std::isfinite(length) && length > 0.0, "a length to be rounded must be above 0");
  const double decade = std::pow(10.0, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0})
    if (factor * decade <= length) return factor * decade;
  return decade;
}

std::string length_label(double length_m) {
  return length_m < 1.0 ? format("%.0f cm", 100.0 * length_m) : format("%g m", length_m);
}

}  // namespace marco::viewer
