#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/robot_values.hpp"

namespace marco::drivers {

/// A base's emergency stop in a file, which outlives its driver and the computer's restart: one for
/// each LCM network and kind of base, in $XDG_STATE_HOME or ~/.local/state.
class StopLatch {
 public:
  /// @param lcm_url  as given on the command line; its options (ttl) name no other network
  StopLatch(const std::string& base, const std::string& lcm_url);

  /// A file that cannot be read is a stop, too.
  std::optional<EmergencyStop> load() const;
  /// Writes the stop, or removes it. It is on the disk then, which may take seconds.
  /// @throws std::runtime_error naming the file.
  void save(const std::optional<EmergencyStop>& stop) const;

 private:
  std::filesystem::path path_;
};

}  // namespace marco::drivers
