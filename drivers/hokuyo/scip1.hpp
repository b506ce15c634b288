#pragma once

#include <optional>
#include <string>

#include "drivers/hokuyo/mirror.hpp"

namespace marco::drivers::hokuyo {

/// What the emulated laser replies to a request of SCIP 1.1, and does.
struct Scip1Answer {
  std::string text;
  bool scan = false;             ///< a scan: sent when the turn that measures it has ended
  bool leave = false;            ///< from now on it speaks SCIP 2.0
  std::optional<bool> laser_on;  ///< switched
  int baud = 0;                  ///< to change to; 0 = none
};

/// SCIP 1.1, the protocol of the first URG-04LX: echo, one character of status, data without
/// checksums, an empty line. Distances have two characters.
/// @param has_baud  on RS-232, where the speed can be changed
Scip1Answer answer_scip1(const std::string& line,
                         const HokuyoMirror& mirror,
                         bool has_baud,
                         Utime now);

}  // namespace marco::drivers::hokuyo
