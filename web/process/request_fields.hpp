#pragma once

#include <cmath>
#include <string>
#include <string_view>

#include "lcm_tools/base/check.hpp"
#include "web/foxglove/fields.hpp"

/// Fields of a service's request, which anybody may have written. All throw std::invalid_argument
/// that says what is wrong, for the client.
namespace marco::web {

using Json = nlohmann::json;

inline Json parsed(std::string_view text) {
  Json json = foxglove::parse_shallow(text);
  require(json.is_object(), "a request that is not a JSON object");
  return json;
}

inline std::string text_of(const Json& json, const char* name) {
  const auto at = json.find(name);
  if (at == json.end() || at->is_null()) return "";
  require(at->is_string(), std::string(name) + " is not a string");
  const auto text = at->get<std::string>();
  require(text.size() <= 1000 && text.find('\0') == std::string::npos,
          std::string(name) + " is too long");
  return text;
}

inline double number_of(const Json& json, const char* name) {
  const auto at = json.find(name);
  if (at == json.end() || at->is_null()) return 0.0;
  constexpr double kFarthest = 1e5;
  const bool is_sound = at->is_number() && std::abs(at->get<double>()) < kFarthest;
  require(is_sound, std::string(name) + " is not a number, or too large");
  return at->get<double>();
}

inline bool flag_of(const Json& json, const char* name) {
  const auto at = json.find(name);
  require(at != json.end() && at->is_boolean(), std::string(name) + " is neither true nor false");
  return at->get<bool>();
}

}  // namespace marco::web
