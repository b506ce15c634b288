#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lcm_tools/files/channel_pattern.hpp"

namespace marco::relay {

/// Which messages a relay passes on, in both directions. Orders do not pass unless the user permits
/// it: a robot that obeys everybody who reaches its port is a danger, procman's orders start any
/// program, and over a link that stalls an order to move comes late. Orders are the channels that
/// the caller names, and those whose names say so (CMD, COMMAND, ORDERS). One order passes always:
/// EMERGENCY_STOP while it says stop.
class ChannelRule {
 public:
  enum class Orders { held_back, passed_on };

  /// @param channels  POSIX extended, matched against the whole name; "" = all
  /// @param orders    names of channels that are orders besides procman's
  /// @throws std::invalid_argument for an expression that is none
  ChannelRule(const std::string& channels, std::vector<std::string> order_channels, Orders orders);

  bool passes(const std::string& channel, std::span<const uint8_t> data) const;
  bool is_order(const std::string& channel) const;

 private:
  ChannelPattern channels_;
  ChannelPattern order_names_;
  std::vector<std::string> order_channels_;
  Orders orders_;
};

/// "" = all channels. @throws std::invalid_argument saying what is wrong with the expression.
ChannelPattern pattern_of(const std::string& expression);

}  // namespace marco::relay
