#pragma once

#include <vector>

#include "lcm_tools/base/options.hpp"
#include "slam/line_slam/lines/observed_wall.hpp"
#include "slam/line_slam/lines/scan_in_robot.hpp"

namespace marco::slam {

/// Defaults of thesis A, chapter 4.
struct LineExtractorOptions {
  double split_distance_m = 0.05;  ///< d_s: how far a point may lie from its wall
  double max_gap_m = 0.35;         ///< wider gaps between neighbouring points cut a wall
  double max_grazing_gap_m =
      1.2;  ///< ... unless the beams' own spacing on a slanting wall is wider
  int min_points = 5;
  double min_length_m = 0.40;
  double max_range_m = 20.0;       ///< farther points are not used (thesis: 8, its laser's limit)
  int max_outliers_in_a_row = 4;   ///< stray points inside a wall that do not end it
  double touch_m = 0.12;           ///< hits nearer together than this are one surface
  double trim_sigmas = 3.0;        ///< points farther from the fitted line do not count for it
  double surface_sigma_m = 0.002;  ///< roughness of real walls: no point is surer than that
  double least_step_m = 0.025;     ///< parts as far apart across are two walls, if that is sure
  double max_roughness_sigmas = 2.0;  ///< a wall whose points scatter more about it is strays ...
  double rough_length_m = 2.0;        ///< ... unless it is as long

  template <class Visitor>
  void visit(Visitor& v) {
    v("split_distance_m", split_distance_m, Limits{1e-4, 1.0});
    v("max_gap_m", max_gap_m, Limits{1e-3, 10.0});
    v("max_grazing_gap_m", max_grazing_gap_m, Limits{1e-3, 10.0});
    v("min_points", min_points, Limits{3, 1000});
    v("min_length_m", min_length_m, kPositive);
    v("max_range_m", max_range_m, kPositive);
    v("max_outliers_in_a_row", max_outliers_in_a_row, Limits{0, 100});
    v("touch_m", touch_m, kPositive);
    v("trim_sigmas", trim_sigmas, Limits{1.0, 100.0});
    v("surface_sigma_m", surface_sigma_m, kPositive);
    v("least_step_m", least_step_m, kPositive);
    v("max_roughness_sigmas", max_roughness_sigmas, Limits{1.0, 1000.0});
    v("rough_length_m", rough_length_m, kNotNegative);
  }
};

/// Walls of a scan by iterative end-point fit, split and merge (thesis A, ch. 4.1-4.3; Douglas and
/// Peucker 1973).
///
/// What differs: gaps cut first, so that no chord spans one; the merge also steps over a few stray
/// points, so that outliers on a wall do not lose it (fig. 6.2); the regression (4.2), which breaks
/// for steep walls, is a total least squares fit weighted by each beam's error across the wall, and
/// gives the covariance. Not thread-safe: one extractor a thread, whose workspace is reused, so
/// that no call allocates once it has seen the largest scan.
class LineExtractor {
 public:
  /// @throws std::invalid_argument naming an option outside its limits.
  explicit LineExtractor(const LineExtractorOptions& options);

  /// Walls in order of bearing. The reference is valid until the next call.
  const std::vector<ObservedWall>& extract(const ScanInRobot& scan);

 private:
  /// How far behind a wall the next piece of it is looked for.
  static constexpr int kLookAheadPoints = 16;
  static constexpr double square(double value) { return value * value; }
  /// Points first..last in order. Between parts that were put together there may be strays, which
  /// do not lie on its line; the core is its longest stretch without any.
  struct Piece {
    int first = 0, last = 0;
    int core_first = 0, core_last = 0;
    static Piece clean(int first, int last) { return {first, last, first, last}; }
    bool has_strays() const { return core_first != first || core_last != last; }
  };
  /// Sums over points, from which a line comes without another look at them.
  struct Sums {
    double weight = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
    void add(const Sums& other, double sign);
    void add_point(double x_m, double y_m, double point_weight);
  };
  struct Line {
    double center_x = 0.0, center_y = 0.0;
    double along_x = 1.0, along_y = 0.0;
    double rms_m = 0.0;  ///< weighted distance of its points
    double across_of(const Eigen::Vector2d& p) const { return across_of(p.x(), p.y()); }
    double across_of(double x, double y) const {
      return along_x * (y - center_y) - along_y * (x - center_x);
    }
    double along_of(double x, double y) const {
      return along_x * (x - center_x) + along_y * (y - center_y);
    }
  };

  void take_points(const ScanInRobot& scan);
  void cut_at_gaps();
  bool is_gap_after(int point) const;
  void split(Piece chain);
  int farthest_from_chord(const Piece& piece) const;
  void merge();
  bool fits_together(const Piece& before, const Piece& after) const;
  bool is_bridged(int before, int after, const Line& line) const;
  bool is_opening(int before, int after, const Line& line) const;
  double squared_distance(int a, int b) const;
  bool lie_on(int first, int last, const Line& line) const;
  Sums sums_of(int first, int last) const;
  static Line line_of(const Sums& sums);
  void choose_members(int from, int to, const Line& line);
  void cut_members_at_gaps(const Line& line);
  Line fit_members() const;
  void accept(std::size_t piece_index);
  std::size_t step_in_members(const Line& line) const;
  void emit_parts(const Line& line);
  void emit(const Line& line);
  double spacing_at(std::size_t member, int inwards) const;
  bool end_is_seen(int beam, int step, const ObservedWall& wall) const;

  LineExtractorOptions options_;
  // Points of the scan at hand, without the beams that brought nothing.
  std::vector<double> x_, y_, range2_, inverse_range2_;
  std::vector<int> beam_;
  std::vector<double> gap2_;  ///< squared distance to the next point
  std::vector<Sums> sums_;    ///< of all points before this one
  std::vector<Piece> pieces_, merged_, stack_;
  std::vector<int> members_, rest_;             ///< points of the wall being fitted
  std::vector<double> weights_, rest_weights_;  ///< 1 / variance across the wall, per member
  std::vector<ObservedWall> walls_;
  const ScanInRobot* scan_ = nullptr;  ///< during extract() only
};

}  // namespace marco::slam
