#include "lcm_tools/files/channel_pattern.hpp"

#include <regex>
#include <stdexcept>

namespace marco {
namespace {

std::regex compiled(const std::string& text, ChannelPattern::Case letters) {
  auto syntax = std::regex::extended | std::regex::optimize;
  if (letters == ChannelPattern::Case::ignored) syntax |= std::regex::icase;
  try {
    return std::regex(text, syntax);
  } catch (const std::regex_error& wrong) {
    throw std::invalid_argument("'" + text + "' is not a regular expression: " + wrong.what());
  }
}

}  // namespace

struct ChannelPattern::Compiled {
  std::regex expression;
};

ChannelPattern::ChannelPattern(const std::string& text, Case letters)
    : compiled_(std::make_shared<const Compiled>(Compiled{compiled(text, letters)})) {}

bool ChannelPattern::matches(const std::string& channel) const {
  return std::regex_match(channel, compiled_->expression);
}

}  // namespace marco
