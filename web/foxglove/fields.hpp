#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

/// Fields of the protocol's texts and bytes, for both of its sides. The other side may have sent
/// anything: what is missing or of another type is empty.
namespace marco::foxglove {

using Json = nlohmann::json;

constexpr uint8_t kData = 1;  ///< opcode of a message on a channel, both ways

/// Nothing deeper than anybody's messages need to be is parsed. Else, and for what is no JSON, the
/// result is discarded.
inline Json parse_shallow(std::string_view text) {
  constexpr int kDeepest = 8;
  int depth = 0, deepest = 0;
  bool is_quoted = false;
  for (std::size_t i = 0; i < text.size() && deepest <= kDeepest; ++i) {
    const char c = text[i];
    if (c == '"') is_quoted = !is_quoted;
    if (is_quoted) {
      i += c == '\\' ? 1 : 0;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest > kDeepest ? Json(Json::value_t::discarded) : Json::parse(text, nullptr, false);
}

inline std::string text_of(const Json& object, const char* key) {
  const auto field = object.find(key);
  return field != object.end() && field->is_string() ? field->get<std::string>() : std::string();
}

inline const Json& list_of(const Json& object, const char* key) {
  static const Json kNone = Json::array();
  const auto field = object.find(key);
  return field != object.end() && field->is_array() ? *field : kNone;
}

/// Nothing unless `value` is a whole number of 32 bits.
inline std::optional<uint32_t> id_of(const Json& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  const auto id = value.get<uint64_t>();
  if (id > std::numeric_limits<uint32_t>::max()) return std::nullopt;
  return static_cast<uint32_t>(id);
}

/// The same of a field of an object.
inline std::optional<uint32_t> id_at(const Json& object, const char* key) {
  if (!object.is_object()) return std::nullopt;
  const auto field = object.find(key);
  return field == object.end() ? std::nullopt : id_of(*field);
}

inline std::set<std::string> texts_of(const Json& list) {
  std::set<std::string> texts;
  for (const Json& item : list) {
    if (item.is_string()) texts.insert(item.get<std::string>());
  }
  return texts;
}

/// The `op` of a text, and the text. @throws std::invalid_argument where there is none.
inline std::pair<std::string, Json> operation_of(std::string_view text) {
  Json object = parse_shallow(text);
  if (!object.is_object()) throw std::invalid_argument("a text that is not a JSON object");
  std::string op = text_of(object, "op");
  if (op.empty()) throw std::invalid_argument("a text without an op");
  return {std::move(op), std::move(object)};
}

/// Little endian. The caller has checked the length.
template <class Number>
Number number_at(std::span<const uint8_t> bytes, std::size_t at) {
  Number value = 0;
  for (std::size_t i = sizeof value; i-- > 0;) value = (value << 8U) | bytes[at + i];
  return value;
}

template <class Bytes, class Number>
void append_number(Bytes& bytes, Number number) {
  for (std::size_t i = 0; i < sizeof number; ++i) {
    bytes.push_back(static_cast<typename Bytes::value_type>(number >> 8 * i & 0xFF));
  }
}

}  // namespace marco::foxglove
