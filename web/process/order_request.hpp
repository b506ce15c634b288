#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace marco::web {

using Json = nlohmann::json;

/// What a client asks of a service. Clients may send anything: all of these throw
/// std::invalid_argument that names what is wrong.
Json parsed(std::string_view text);

/// A field's text, at most 1000 bytes; "" where it is missing or null.
std::string text_of(const Json& json, const char* name);

/// A field's number, finite and of a sane size; 0 where it is missing or null.
double number_of(const Json& json, const char* name);

/// A field that must be there.
bool flag_of(const Json& json, const char* name);

}  // namespace marco::web
