#pragma once

#include <optional>
#include <string>

#include "common/samples.hpp"

namespace marco {

/// Tells odometry that was given in other units than metres and radians: where its steps count as
/// motion, many are faster than any robot that maps a building. Not thread-safe.
class OdometryUnits {
 public:
  /// @returns what is wrong, for a person: from the sample on that makes it certain, always the
  /// same. Odometry that is too slow looks like a slow robot, and is for the calibration to find.
  std::optional<std::string> look(const OdometrySample& sample);
  const std::optional<std::string>& verdict() const { return verdict_; }

 private:
  /// Steps that count as motion, and of them those that are too fast. Both are halved now and then,
  /// so that a robot that was carried is forgiven.
  struct Steps {
    int moving = 0;
    int too_fast = 0;
    double fastest = 0.0;  ///< [m/s or rad/s]

    void note(double moved, double seconds, double counts_from, double limit);
    bool are_wrong() const;
  };

  std::optional<OdometrySample> last_;
  int steps_ = 0;
  double seconds_ = 0.0;  ///< of all steps
  Steps ways_, turns_;
  std::optional<std::string> verdict_;
};

}  // namespace marco
