#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/laser_scan.hpp"

namespace marco {

/// Tells ranges that were given in millimetres or centimetres: of the first scans of a channel half
/// the returns lie farther away than any laser that maps a building sees, whatever the unit. Ranges
/// that repeat themselves are codes for "no return", and do not count. Not thread-safe.
class RangeUnits {
 public:
  /// @returns what is wrong, for a person: from the scan on that makes it certain, always the same.
  std::optional<std::string> look(const LaserScan& scan);

 private:
  struct Channel {
    int scans = 0;
    std::vector<float> ranges_m;
    std::optional<std::string> verdict;
  };
  std::map<std::string, Channel> channels_;
};

}  // namespace marco
