#pragma once

#include <memory>
#include <string>

#include "common/process/lcm_bus.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco::spy {

/// Stops every base by EMERGENCY_STOP, and releases them. A message may be lost: each order goes
/// out ten times. One thread.
class StopSwitch {
 public:
  /// @param url of the bus, which is opened with the first order
  explicit StopSwitch(std::string url) : url_(std::move(url)) {}

  enum class Order { stop, release };
  /// Sends at once. @throws std::runtime_error when LCM cannot open the url.
  void order(Order order);
  /// Sends again what is left of the last order; call it ten times a second.
  void repeat();
  /// Sends all that is left, within 0.2 s.
  void finish();

 private:
  std::string url_;
  std::unique_ptr<process::LcmBus> bus_;
  emergency_stop_t message_ = {};
  int left_ = 0;
};

}  // namespace marco::spy
