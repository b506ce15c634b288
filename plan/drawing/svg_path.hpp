#pragma once

#include <Eigen/Core>
#include <string_view>
#include <vector>

namespace marco::plan {

/// A chain of points of a path.
struct SvgChain {
  std::vector<Eigen::Vector2d> points;
  std::vector<bool> curved;  ///< of the line that ends at each point
};

/// Reads numbers as SVG writes them: separated by blanks, commas, signs or second points.
class SvgNumbers {
 public:
  explicit SvgNumbers(std::string_view text) : rest_(text) {}
  /// Whether nothing but blanks is left.
  bool at_end();
  /// The next letter where one comes next, else 0.
  char letter();
  /// @throws std::invalid_argument where no finite number comes next.
  double number();
  /// A flag of an arc: one digit.
  bool flag();

 private:
  void skip();
  std::string_view rest_;
};

/// The attribute `d` of a path: all commands of SVG 1.1, curves as chords.
/// @throws std::invalid_argument for what is no path data, and beyond 2 million points.
std::vector<SvgChain> read_svg_path(std::string_view data);

}  // namespace marco::plan
