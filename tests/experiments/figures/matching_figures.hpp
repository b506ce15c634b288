#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/pose2.hpp"
#include "tests/experiments/figures/thesis_figures.hpp"

namespace marco {

/// A scan where the robot stopped to match, and what else is known of the place.
struct WalkScan {
  Points2 points_in_robot;  ///< 2xN [m], in the order of the beams
  Pose2 odom_from_robot;
  std::optional<Pose2> world_from_robot;  ///< the truth
};

/// A path made by one of the thesis' methods; world = the first scan's robot frame.
struct MatchedWalk {
  std::string name;
  std::vector<Pose2> world_from_robot;  ///< one a scan
  double rms_m = 0.0;                   ///< against the truth, both from the first scan on
  double max_m = 0.0;
  double ms_per_match = 0.0;  ///< of CPU
};

/// Thesis B's lab run (ch. 5.2): by odometry alone, by matching each scan with the one before
/// (least squares, the Lorentzian, the Lorentzian with calculated points), and with all scans
/// before.
std::vector<MatchedWalk> match_walks(const std::vector<WalkScan>& scans);

/// Writes the equals of figures 5.3-5.9 (a sheet for each of nine scans at most: the robot as a
/// half disc, its rays and the map so far by four methods), 5.10 (one pair of scans, least squares
/// against the Lorentzian) and 5.11 (closer). @throws std::invalid_argument of fewer than two
/// scans.
std::vector<Figure> draw_matching_figures(const std::filesystem::path& folder,
                                          const std::vector<WalkScan>& scans,
                                          const std::vector<MatchedWalk>& walks);

}  // namespace marco
