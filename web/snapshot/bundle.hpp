#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace marco::web {

/// Joins ES modules into one classic script, since browsers load no modules from a file on disk.
/// Each module becomes a function of its own scope that returns what it exports; a module runs
/// once, behind those it imports. Understands what the page uses: `import { a, b } from "./x.js";`
/// on one line, and `export` before function, async function, class or const.
/// @param entry  name of the first module
/// @param text_of  content of a module by its name; nothing when there is none
/// @throws std::invalid_argument naming the module that is missing, or the line that it does not
/// understand; also when modules import each other in a ring.
std::string bundle_modules(
    const std::string& entry,
    const std::function<std::optional<std::string_view>(std::string_view)>& text_of);

}  // namespace marco::web
