#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace marco::files {

/// Whether `name` stays below the folder it is read from: relative, never up by "..".
inline bool stays_inside(const std::filesystem::path& name) {
  const std::filesystem::path normal = name.lexically_normal();
  return !normal.is_absolute() && (normal.empty() || *normal.begin() != "..");
}

/// An untrusted `name` as a path within `folder`. Links are not resolved.
/// @throws std::invalid_argument when it would lie outside: absolute, or up by "..".
inline std::filesystem::path inside_folder(const std::filesystem::path& folder,
                                           const std::filesystem::path& name) {
  if (!stays_inside(name)) {
    throw std::invalid_argument("'" + name.string() + "' lies outside of its folder");
  }
  return folder / name.lexically_normal();
}

}  // namespace marco::files
