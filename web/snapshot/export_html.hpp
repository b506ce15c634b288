#pragma once

#include <filesystem>
#include <string>

namespace marco::web {

/// The page with a map folder in it: one HTML file that any browser opens from disk, without
/// network. It holds page, snapshot, model and photographs.
/// @param three  file of three.js, which goes into it when the folder has a model; where it is
/// missing the model is left out.
/// @throws std::invalid_argument as snapshot_json does.
std::string export_html(const std::filesystem::path& folder, const std::filesystem::path& three);

/// Where Debian's libjs-three lies.
inline constexpr const char* kDebianThree = "/usr/share/javascript/three/three.min.js";

}  // namespace marco::web
