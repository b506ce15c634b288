// How the robot moved between two scans of a recording, by the scans alone.   match_two_scans LOG
// FIRST SECOND
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "recordings/recording.hpp"
#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/nlm_matcher.hpp"

namespace {

// The returns as points in the frame of the laser.
marco::Points2 points_of(const marco::LaserScan& scan, double range_max_m) {
  marco::Points2 points(2, static_cast<Eigen::Index>(scan.size()));
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double range = scan.ranges_m[i];
    if (!(range > 0.0 && range < range_max_m)) continue;
    points.col(count++) << range * std::cos(scan.bearing_rad(i)),
        range * std::sin(scan.bearing_rad(i));
  }
  return points.leftCols(count);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: match_two_scans LOG FIRST SECOND\n"), 2;
  const auto recording = marco::open_recording(argv[1]);
  std::vector<marco::LaserScan> scans;
  double range_max_m = marco::kFarthestReturnM;
  while (const auto sample = recording->next()) {
    if (const auto* scan = std::get_if<marco::LaserScan>(&*sample)) scans.push_back(*scan);
    if (const auto* info = std::get_if<marco::SensorInfo>(&*sample))
      range_max_m = info->range_max_m;
  }
  const marco::Points2 first = points_of(scans.at(std::strtoul(argv[2], nullptr, 10)), range_max_m);
  const marco::Points2 second =
      points_of(scans.at(std::strtoul(argv[3], nullptr, 10)), range_max_m);

  // An exhaustive search within 1 m and 30 degrees, then Newton-Levenberg-Marquardt.
  const marco::slam::CorrelativeMatcher search;
  const auto coarse = search.search(marco::slam::LikelihoodPyramid(first, search.options()), second,
                                    {{}, 1.0, marco::deg_to_rad(30.0)}, 0.0);
  const marco::slam::NlmMatcher matcher;
  const auto fine = matcher.match(marco::slam::NlmTarget(first), second, coarse.map_from_robot);
  std::printf(
      "x %.3f m, y %.3f m, heading %.2f deg; %.0f %% of the points lie on walls of the first "
      "scan\n",
      fine.target_from_source.x_m, fine.target_from_source.y_m,
      marco::rad_to_deg(fine.target_from_source.theta_rad), 100.0 * fine.overlap);
}
