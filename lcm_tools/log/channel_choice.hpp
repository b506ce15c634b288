#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "lcm_tools/files/channel_pattern.hpp"

namespace marco::logs {

/// Which channels somebody wants. Each is decided once and remembered.
class ChannelChoice {
 public:
  enum class Sense { keep, drop };

  /// Everything.
  ChannelChoice() = default;

  /// @param patterns  a name, or a POSIX extended regular expression over the whole name; none =
  ///                  everything.
  /// @param sense     whether those that fit are kept or dropped.
  /// @throws std::invalid_argument quoting the pattern that is no regular expression.
  ChannelChoice(const std::vector<std::string>& patterns, Sense sense);

  bool keeps(std::string_view channel);

 private:
  bool fits(const std::string& channel) const;

  std::vector<ChannelPattern> patterns_;
  Sense sense_ = Sense::drop;
  std::map<std::string, bool, std::less<>> decided_;
};

}  // namespace marco::logs
