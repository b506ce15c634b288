#include "lcm_tools/relay/channel_rule.hpp"

#include <algorithm>
#include <utility>

#include "lcm_tools/lcmtypes/channels.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco::relay {
namespace {

bool says_stop(std::span<const uint8_t> data) {
  emergency_stop_t message{};
  const int size = static_cast<int>(data.size());
  return message.decode(data.data(), 0, size) == size && message.engaged != 0;
}

}  // namespace

ChannelPattern pattern_of(const std::string& expression) {
  return ChannelPattern(expression.empty() ? ".*" : expression);
}

ChannelRule::ChannelRule(const std::string& channels,
                         std::vector<std::string> order_channels,
                         Orders orders)
    : channels_(pattern_of(channels)),
      order_names_(".*(CMD|COMMAND|ORDERS).*", ChannelPattern::Case::ignored),
      order_channels_(std::move(order_channels)),
      orders_(orders) {
  order_channels_.insert(order_channels_.end(), channels::kToolOrders.begin(),
                         channels::kToolOrders.end());
}

bool ChannelRule::is_order(const std::string& channel) const {
  return std::find(order_channels_.begin(), order_channels_.end(), channel) !=
             order_channels_.end() ||
         order_names_.matches(channel);
}

bool ChannelRule::passes(const std::string& channel, std::span<const uint8_t> data) const {
  if (channel == channels::kEmergencyStop && says_stop(data)) return true;
  if (orders_ == Orders::held_back && is_order(channel)) return false;
  return channels_.matches(channel);
}

}  // namespace marco::relay
