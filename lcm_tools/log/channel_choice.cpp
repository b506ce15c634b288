#include "lcm_tools/log/channel_choice.hpp"

#include <algorithm>
#include <stdexcept>

namespace marco::logs {

ChannelChoice::ChannelChoice(const std::vector<std::string>& patterns, Sense sense)
    : sense_(patterns.empty() ? Sense::drop : sense) {
  for (const std::string& pattern : patterns) {
    try {
      patterns_.emplace_back(pattern);
    } catch (const std::invalid_argument&) {
      throw std::invalid_argument("'" + pattern +
                                  "' is neither a channel name nor a regular expression");
    }
  }
}

bool ChannelChoice::fits(const std::string& channel) const {
  return std::any_of(patterns_.begin(), patterns_.end(),
                     [&](const ChannelPattern& pattern) { return pattern.matches(channel); });
}

bool ChannelChoice::keeps(std::string_view channel) {
  const auto known = decided_.find(channel);
  if (known != decided_.end()) return known->second;
  std::string name(channel);
  const bool kept = fits(name) == (sense_ == Sense::keep);
  // Damage can invent channel names without end.
  constexpr std::size_t kRemembered = 10000;
  if (decided_.size() < kRemembered) decided_.emplace(std::move(name), kept);
  return kept;
}

}  // namespace marco::logs
