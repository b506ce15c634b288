#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "lcm_tools/log/player.hpp"
#include "lcm_tools/process/batch_bus.hpp"
#include "web/hub.hpp"

namespace marco::web {

/// A recording of any known format that plays in a loop, as it was recorded or faster: LCM logs as
/// they are; of others the laser, odometry and the like, as marco-log imports them. Clients of
/// Foxglove's newer protocol pause it, and go to other moments. No network is touched.
class Recording {
 public:
  /// @throws std::invalid_argument naming the file, when it is no recording.
  Recording(const std::filesystem::path& path, double speed);
  ~Recording() = default;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  process::BatchBus& bus() { return bus_; }
  const logs::LogSpan& span() const { return player_->span(); }
  Utime position() const { return player_->position(); }
  /// From here on clients control it. The hub outlives it.
  void serve(Hub& hub);

  /// Plays what is due. @param now_us  monotonic. @returns how long to wait for the next [ms].
  int advance(int64_t now_us);

 private:
  void control(const foxglove::PlaybackControl& control);

  process::BatchBus bus_;
  std::unique_ptr<logs::Player> player_;
  Hub* hub_ = nullptr;
};

}  // namespace marco::web
