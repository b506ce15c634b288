#pragma once

#include <cstdint>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/lcm_bus.hpp"

namespace marco::web {

/// The 3D model is sent when it is asked for: it is refined first, which costs marco-mapping3d
/// seconds. While somebody watches, it is asked for after each sweep.
class ModelRequests {
 public:
  /// @param live  null: nothing is asked for. Outlives it.
  explicit ModelRequests(process::LcmBus* live) : live_(live) {}

  void take(const process::RawMessage& message);
  /// Call often. @param now_us  monotonic
  void step(int64_t now_us, bool somebody_watches);

 private:
  process::LcmBus* live_;
  bool has_new_rows_ = false;  // of a sweep, since the last step
  bool is_due_ = false;        // a sweep that the last model does not hold
  int64_t heard_us_ = 0, asked_us_ = 0;
};

}  // namespace marco::web
