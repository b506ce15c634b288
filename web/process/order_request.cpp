#include "web/process/order_request.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "lcm_tools/base/check.hpp"

namespace marco::web {

Json parsed(std::string_view text) {
  Json json = Json::parse(text, nullptr, false);
  require(json.is_object(), "a request that is no JSON object");
  return json;
}

std::string text_of(const Json& json, const char* name) {
  const auto at = json.find(name);
  if (at == json.end() || at->is_null()) return "";
  require(at->is_string(), std::string(name) + " is no text");
  const auto text = at->get<std::string>();
  require(text.size() <= 1000 && text.find('\0') == std::string::npos,
          std::string(name) + " is too long");
  return text;
}

double number_of(const Json& json, const char* name) {
  const auto at = json.find(name);
  if (at == json.end() || at->is_null()) return 0.0;
  constexpr double kFarthest = 1e5;
  const bool is_sound = at->is_number() && std::abs(at->get<double>()) < kFarthest;
  require(is_sound, std::string(name) + " is no number, or too large");
  return at->get<double>();
}

bool flag_of(const Json& json, const char* name) {
  const auto at = json.find(name);
  require(at != json.end() && at->is_boolean(), std::string(name) + " is neither true nor false");
  return at->get<bool>();
}

}  // namespace marco::web
