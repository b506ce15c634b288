#pragma once

#include <vector>

#include "recordings/ros/messages.hpp"

namespace marco::ros {

/// The bearings of the laser behind flat clouds that leave out the beams without a return: learned
/// from all of them, so that each becomes a scan of the same beams.
class BearingGrid {
 public:
  void add(const CloudMessage& cloud);

  double first_rad() const { return least_rad_; }
  double step_rad() const;
  /// One range a beam, 0 where there is no point. Empty where points lie between the beams.
  std::vector<float> ranges_m(const CloudMessage& cloud) const;

 private:
  double least_rad_ = 0.0, most_rad_ = 0.0;
  double told_step_rad_ = 0.0;  ///< by the fullest cloud; 0 none yet
  std::size_t fullest_ = 0;
};

}  // namespace marco::ros
