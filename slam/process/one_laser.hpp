#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "common/laser_scan.hpp"

namespace marco::slam {

/// Keeps to the first of two lasers that publish on one channel, as when two robots share a
/// network. Nothing in a message says whose it is. But the stamps of one laser are a steady row,
/// into which a second one's fall; and one laser's scans, taken shortly after each other, look
/// alike, while another's look different. Only what both tell is refused:
///
/// - a scan came much sooner than the row allows, less than kAlarm ago, and
/// - this scan is unlike the last one that was like those before it, of less than kMemory ago.
///
/// So nothing is refused of a laser that is alone, or whose stamps come in bursts, or whose scans
/// do not look alike (another number of beams each). A second laser is not told from the first one
/// where both see the same, nor where the first is silent.
class OneLaser {
 public:
  /// @returns false for a scan of another laser; call for each scan of one channel, in the order
  /// of arrival.
  bool is_ours(const LaserScan& scan);

  static constexpr Duration kAlarm = Duration::from_seconds(3.0);
  static constexpr Duration kMemory = Duration::from_seconds(1.0);

 private:
  bool too_soon(Duration step) const;
  void learn(Duration step, bool alike);

  std::deque<double> steps_s_;  ///< between scans without alarm
  double alike_share_ = 0.0;    ///< of the last ten or so of them
  std::optional<LaserScan> trusted_;
  std::optional<LaserScan> doubtful_;  ///< the last one, when it was unlike the trusted one
  std::optional<Utime> newest_;
  std::optional<Utime> alarm_;
};

/// Whether two scans of one laser may have been taken shortly after each other: most ranges agree,
/// turned against each other by up to 15 degrees. False for different numbers of beams.
bool look_alike(const LaserScan& a, const LaserScan& b);

}  // namespace marco::slam
