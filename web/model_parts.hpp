#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "lcm_tools/process/bus.hpp"

namespace marco::web {

/// Tiles of the 3D model (mesh_t) that wait for their turn: a hundred come at once, each takes
/// milliseconds, and poses and orders come between them.
class ModelParts {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;

  /// Keeps a tile, in place of those that wait of an earlier model of its channel.
  /// @returns false for any other message, and where there is no room: to be taken at once
  bool put(const process::RawMessage& message);
  /// Gives the `most` oldest ones.
  void give(int most, const std::function<void(const process::RawMessage&)>& take);

 private:
  struct Part {
    std::string channel;
    std::vector<uint8_t> bytes;
    Utime event_time;
    int64_t revision = 0;
  };
  std::deque<Part> waiting_;
};

}  // namespace marco::web
