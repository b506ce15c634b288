#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "viewer/picture.hpp"

namespace marco::viewer {

/// Antialiased lines, shapes and words on a picture. Coordinates are pixels of the finished
/// picture, x right, y down, (0, 0) the outer corner of the first pixel; fractions are allowed.
/// Drawn internally at twice the size; finish() averages. Not thread-safe.
class Canvas {
 public:
  Canvas(int width_px, int height_px, Rgb background);

  /// Starts from a finished picture. @param picture its pixels are the background.
  explicit Canvas(const Picture& picture);

  int width_px() const { return picture_.width_px / kOversampling; }
  int height_px() const { return picture_.height_px / kOversampling; }

  void fill_rectangle(const Eigen::Vector2d& min_px, const Eigen::Vector2d& max_px, Rgb color);
  void fill_polygon(std::span<const Eigen::Vector2d> corners_px, Rgb color);
  void fill_disc(const Eigen::Vector2d& center_px, double radius_px, Rgb color);
  void draw_line(const Eigen::Vector2d& from_px,
                 const Eigen::Vector2d& to_px,
                 Rgb color,
                 double thickness_px);
  void draw_polyline(std::span<const Eigen::Vector2d> points_px, Rgb color, double thickness_px);

  /// Draws a picture into the rectangle: enlarged without smoothing, so that map cells keep their
  /// edges, or shrunk by averaging.
  void paste(const Picture& image, const Eigen::Vector2d& min_px, const Eigen::Vector2d& max_px);

  /// Words (ASCII only). @param anchor_px left end of the line, at half the height of a capital.
  void draw_text(const std::string& text,
                 const Eigen::Vector2d& anchor_px,
                 double height_px,
                 Rgb color);
  /// Width the words will take [px]. @param height_px of a capital.
  static double text_width_px(const std::string& text, double height_px);

  /// The picture at its own size.
  Picture finish() const;

 private:
  static constexpr int kOversampling = 2;
  Picture picture_;
};

}  // namespace marco::viewer
