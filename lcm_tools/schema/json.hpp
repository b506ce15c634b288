#pragma once

#include <string>

#include "lcm_tools/schema/decoder.hpp"

namespace marco::lcm_schema {

struct JsonOptions {
  bool bytes_as_base64 = false;         ///< `byte` arrays as text instead of numbers
  std::size_t max_elements = SIZE_MAX;  ///< of an array; longer ones end with "... N more"
};

/// Appends the message as one JSON object, fields in wire order, no line break. Numbers read back
/// exactly (shortest text); NaN and infinities are null; bytes of a string that are not UTF-8
/// become U+FFFD. Arrays of several dimensions nest row by row.
void append_json(const Tree& tree, std::string& out, const JsonOptions& options = {});

std::string to_base64(std::span<const uint8_t> bytes);

/// `text` in quotes with JSON's escapes, as above.
void append_json_string(std::string_view text, std::string& out);

/// JSON Schema (2020-12 subset: type, properties, items, contentEncoding) of what append_json
/// writes for this type; a type inside itself is left open there ({}).
std::string json_schema(const Schema& schema, int structure, const JsonOptions& options = {});

}  // namespace marco::lcm_schema
