#pragma once

#include <cstdint>
#include <string>

#include "web/hub.hpp"

namespace marco::web {

/// The JSON schema of a channel of our own page, "page/tiles" and its like.
/// @throws std::invalid_argument for another name.
std::string page_schema(const std::string& topic);

/// Adds that channel to the hub. @returns its id.
uint32_t add_page_channel(Hub& hub, const std::string& topic);

}  // namespace marco::web
