#include "viewer/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "lcm_tools/base/check.hpp"

namespace marco::viewer {
namespace {

// OpenCV can draw at 1/16 pixel; finer than an eye sees.
constexpr int kShift = 4;
constexpr double kCapitalOfHersheyPx = 21.0;
constexpr int kFont = cv::FONT_HERSHEY_DUPLEX;

cv::Mat view(Picture& picture) {
  return {picture.height_px, picture.width_px, CV_8UC3, picture.pixels.data()};
}
cv::Mat view(const Picture& picture) {
  // Only read from: cv::Mat knows no const pixels.
  return {picture.height_px, picture.width_px, CV_8UC3, const_cast<Rgb*>(picture.pixels.data())};
}
cv::Scalar scalar(Rgb color) { return {1.0 * color.red, 1.0 * color.green, 1.0 * color.blue}; }

// OpenCV means the middle of a pixel by a whole number. Far points are pulled in, since its fixed
// point would overflow; a segment that leaves the picture by so much is not seen at its far end.
cv::Point fixed_point(const Eigen::Vector2d& point_px, int oversampling) {
  constexpr double kFar = 1 << 24;
  const Eigen::Vector2d scaled =
      ((point_px * oversampling - Eigen::Vector2d::Constant(0.5)) * (1 << kShift))
          .cwiseMax(-kFar)
          .cwiseMin(kFar);
  return {static_cast<int>(std::lround(scaled.x())), static_cast<int>(std::lround(scaled.y()))};
}

}  // namespace

Canvas::Canvas(int width_px, int height_px, Rgb background)
    : picture_(width_px * kOversampling, height_px * kOversampling, background) {
  require(width_px > 0 && height_px > 0, "a canvas needs a size above 0 px");
}

Canvas::Canvas(const Picture& picture) : Canvas(picture.width_px, picture.height_px, {}) {
  paste(picture, {0, 0}, {picture.width_px, picture.height_px});
}

void Canvas::fill_rectangle(const Eigen::Vector2d& min_px,
                            const Eigen::Vector2d& max_px,
                            Rgb color) {
  const std::array<Eigen::Vector2d, 4> corners{
      {min_px, {max_px.x(), min_px.y()}, max_px, {min_px.x(), max_px.y()}}};
  fill_polygon(corners, color);
}

void Canvas::fill_polygon(std::span<const Eigen::Vector2d> corners_px, Rgb color) {
  std::vector<cv::Point> points;
  for (const Eigen::Vector2d& corner : corners_px)
    points.push_back(fixed_point(corner, kOversampling));
  cv::Mat image = view(picture_);
  cv::fillPoly(image, std::vector<std::vector<cv::Point>>{points}, scalar(color), cv::LINE_AA,
               kShift);
}

void Canvas::fill_disc(const Eigen::Vector2d& center_px, double radius_px, Rgb color) {
  cv::Mat image = view(picture_);
  const int radius = static_cast<int>(std::lround(radius_px * kOversampling * (1 << kShift)));
  cv::circle(image, fixed_point(center_px, kOversampling), std::max(radius, 1), scalar(color),
             cv::FILLED, cv::LINE_AA, kShift);
}

void Canvas::draw_line(const Eigen::Vector2d& from_px,
                       const Eigen::Vector2d& to_px,
                       Rgb color,
                       double thickness_px) {
  const std::array<Eigen::Vector2d, 2> ends{from_px, to_px};
  draw_polyline(ends, color, thickness_px);
}

void Canvas::draw_polyline(std::span<const Eigen::Vector2d> points_px,
                           Rgb color,
                           double thickness_px) {
  std::vector<cv::Point> points;
  for (const Eigen::Vector2d& point : points_px)
    points.push_back(fixed_point(point, kOversampling));
  const int thickness = std::max(1, static_cast<int>(std::lround(thickness_px * kOversampling)));
  cv::Mat image = view(picture_);
  cv::polylines(image, points, false, scalar(color), thickness, cv::LINE_AA, kShift);
}

void Canvas::paste(const Picture& image,
                   const Eigen::Vector2d& min_px,
                   const Eigen::Vector2d& max_px) {
  const Eigen::Vector2i from = (min_px * kOversampling).array().round().cast<int>();
  const Eigen::Vector2i to = (max_px * kOversampling).array().round().cast<int>();
  require(from.x() >= 0 && from.y() >= 0 && to.x() <= picture_.width_px &&
              to.y() <= picture_.height_px && (to - from).minCoeff() > 0,
          "a pasted picture must be inside the canvas");
  cv::Mat target =
      view(picture_)(cv::Rect(from.x(), from.y(), to.x() - from.x(), to.y() - from.y()));
  const bool shrinks = target.cols < image.width_px;
  cv::resize(view(image), target, target.size(), 0, 0,
             shrinks ? cv::INTER_AREA : cv::INTER_NEAREST);
}

void Canvas::draw_text(const std::string& text,
                       const Eigen::Vector2d& anchor_px,
                       double height_px,
                       Rgb color) {
  const double scale = height_px * kOversampling / kCapitalOfHersheyPx;
  const int thickness = std::max(1, static_cast<int>(std::lround(height_px / 7.0)));
  const cv::Point left_bottom(
      static_cast<int>(std::lround(anchor_px.x() * kOversampling)),
      static_cast<int>(std::lround((anchor_px.y() + 0.5 * height_px) * kOversampling)));
  cv::Mat image = view(picture_);
  cv::putText(image, text, left_bottom, kFont, scale, scalar(color), thickness, cv::LINE_AA);
}

double Canvas::text_width_px(const std::string& text, double height_px) {
  const double scale = height_px * kOversampling / kCapitalOfHersheyPx;
  int baseline = 0;
  return cv::getTextSize(text, kFont, scale, 1, &baseline).width / (1.0 * kOversampling);
}

Picture Canvas::finish() const {
  Picture result(width_px(), height_px(), {});
  cv::Mat target = view(result);
  cv::resize(view(picture_), target, target.size(), 0, 0, cv::INTER_AREA);
  return result;
}

}  // namespace marco::viewer
