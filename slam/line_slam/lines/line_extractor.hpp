#pragma once

#include <vector>

#include "slam/line_slam/lines/observed_wall.hpp"
#include "slam/line_slam/lines/scan_points.hpp"
#include "slam/line_slam/lines/split_and_merge.hpp"
#include "slam/line_slam/lines/wall_fitter.hpp"

namespace marco::slam {

/// Line extraction: the walls of a scan by split and merge (SplitAndMerge), then line fitting with
/// covariance (WallFitter); thesis A, 4.1-4.3. Not thread-safe: use one extractor per thread. Its
/// workspace is reused, so that no call allocates once it has seen the largest scan.
class LineExtractor {
 public:
  /// @throws std::invalid_argument naming an option outside its limits.
  explicit LineExtractor(const LineExtractorOptions& options);

  /// Walls in order of bearing. The reference is valid until the next call.
  const std::vector<ObservedWall>& extract(const ScanInRobot& scan);

 private:
  ScanPoints points_;
  SplitAndMerge split_and_merge_;
  WallFitter fitter_;
  std::vector<ObservedWall> walls_;
};

}  // namespace marco::slam
