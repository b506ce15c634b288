#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "common/laser_scan.hpp"
#include "lcm_tools/process/drop_counter.hpp"

namespace marco::slam {

/// Tells the scans of the laser that was heard first from those that another robot sends on the
/// same channel, where nothing in a message says whose it is: a fast laser's next scan hardly
/// differs from the one before, and comes in its rhythm. Scans that contradict it wait: when the
/// first laser goes on they were another's, and are left out, unless they fill the beats that it
/// missed and came on them or lead from the one scan to the other (a busy computer stamps late);
/// when it does not, for half a second, and they keep a rhythm, they are its own (a restarted
/// driver, a laser that was covered or is tilted fast) and come late, but all. One that another
/// robot took where ours is may be believed; the next of ours goes on from the one before it. A
/// laser that takes less than ten scans a second, or one that is just beginning, is believed in
/// everything.
///
/// Depends on the scans and their stamps alone, never on a clock. Not thread-safe. Cost O(beams).
class OneSource {
 public:
  struct Sorted {
    std::vector<LaserScan> own;  ///< in the order of arrival
    int foreign = 0;             ///< so many were another's, and
    int off_beat = 0;            ///< so many look like ours, but not by their stamps: who knows
  };
  Sorted take(LaserScan scan);
  /// What still waits: nothing will tell any more.
  std::vector<LaserScan> rest();

 private:
  struct Beat {
    int periods;  ///< since the last scan, 1 at least; 0 after a gap
    double off;   ///< the stamp is so far from it, of a period
  };
  Beat beat_of(const LaserScan& before, const LaserScan& scan) const;
  bool goes_on(const LaserScan& before, const LaserScan& scan) const;
  /// Nobody's or another's.
  void leave_out(const LaserScan& scan, Sorted& sorted) const;
  /// Whether what waits belongs before `scan`, which goes on.
  bool waits_for(const LaserScan& scan) const;
  /// Whether each looks like the one before, from the last one believed to `scan`.
  bool waiting_lead_to(const LaserScan& scan) const;
  /// Whether what waits could be one laser's: what it sees may change fast on a pan-tilt.
  bool waiting_keep_a_rhythm() const;
  bool is_known() const;
  bool is_regular() const;
  std::size_t patience() const;
  void believe(const LaserScan& scan);

  std::optional<LaserScan> last_;    ///< that was believed
  std::optional<LaserScan> before_;  ///< it
  std::deque<LaserScan> waiting_;
  int steps_ = 0;  ///< that period_s_ is made of
  double period_s_ = 0.0;
  double off_beat_ = 1.0;  ///< on average; small of a laser that keeps a rhythm
};

/// Of what `source` makes of `scan`, those that are ours; what is left out is counted in `drops`.
std::vector<LaserScan> take_own(OneSource& source, LaserScan scan, process::DropCounter& drops);

/// Whether `part` of the beams of `scan` and more measured what the beams about the same bearing
/// did `dt_s` before, for a robot that turns by no more than 2 rad/s and drives no more than 2 m/s.
bool looks_the_same(const LaserScan& before, const LaserScan& scan, double dt_s, double part);

}  // namespace marco::slam
