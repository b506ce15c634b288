#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace marco::plan {

/// A drawing on paper: x to the right and y up from the lower left corner, in millimetres.
struct Sheet {
  struct Style {
    double width_mm = 0.0;  ///< of the stroke; 0: none
    double grey = 0.0;      ///< of the stroke, 0 black .. 1 white
    double fill = -1.0;     ///< grey inside; below 0: none
    std::vector<double> dash_mm;
  };
  /// From a point of a path to the next.
  struct Stretch {
    Eigen::Vector2d from, to;
    double bulge;
  };
  struct Path {
    std::vector<Eigen::Vector2d> points;
    bool closed = false;
    Style style;
    std::string layer = {};  ///< class of it in SVG
    std::vector<double> bulges =
        {};  ///< from each point to the next (bulge.hpp); missing: straight
    /// Of a closed path the one back to its first point only if it is bent.
    std::vector<Stretch> stretches() const;
  };
  enum class Anchor { start, middle, end };
  struct Text {
    Eigen::Vector2d at = {0, 0};  ///< on its base line
    std::string text;             ///< UTF-8
    double height_mm = 2.5;       ///< of the font
    double angle_rad = 0.0;
    Anchor anchor = Anchor::start;
    bool bold = false;
  };

  double width_mm = 210.0;
  double height_mm = 297.0;
  std::string title;
  double scale = 0.0;       ///< 100 for 1:100; 0: no drawing to scale
  std::vector<Path> paths;  ///< later ones cover earlier ones
  std::vector<Text> texts;

  void line(const Eigen::Vector2d& from,
            const Eigen::Vector2d& to,
            const Style& style,
            const std::string& layer = {}) {
    paths.push_back({{from, to}, false, style, layer});
  }
};

/// The sheet as an SVG document whose size is in millimetres. It says its scale for programs, as
/// read_svg() reads it.
std::string sheet_svg(const Sheet& sheet);

struct SheetPdf {
  std::string bytes;
  std::string missing;  ///< letters that no installed font has, each once, UTF-8
};

/// The sheet as a PDF document of one page: vectors, and text in the installed fonts, embedded. A
/// missing letter is drawn as a box with its code; without any font there is no text. The same
/// bytes for the same sheet and fonts.
/// @throws std::runtime_error where cairo fails.
SheetPdf sheet_pdf(const Sheet& sheet);

}  // namespace marco::plan
