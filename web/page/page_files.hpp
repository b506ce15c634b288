#pragma once

#include <optional>
#include <string_view>

namespace marco::web {

/// The content of a file of web/page, which is part of the program: "index.html", "page.css",
/// "map_view.js". Nothing for other names. Safe from several threads.
std::optional<std::string_view> page_file(std::string_view name);

}  // namespace marco::web
