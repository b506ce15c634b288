#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace marco::files {

/// Whether `name` stays below the folder it is read from: relative, never up by "..".
inline bool stays_inside(const std::filesystem::path& name) {
  const std::filesystem::path normal = name.lexically_normal();
  return !normal.is_absolute() && (normal.empty() || *normal.begin() != "..");
}

/// An untrusted `name` as a path within `folder`, which may be a stranger's, too: to be read, with
/// its links resolved. That `folder` is a link itself does not matter.
/// @returns folder/name where nothing of that name is there
/// @throws std::invalid_argument when it lies outside (absolute, up by "..", by a link), and when
/// it is neither a file nor a folder: a FIFO would be waited for.
inline std::filesystem::path inside_folder(const std::filesystem::path& folder,
                                           const std::filesystem::path& name) {
  namespace fs = std::filesystem;
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument("'" + name.string() + "' " + why);
  };
  if (!stays_inside(name)) refuse("is outside its folder");
  const fs::path path = folder / name.lexically_normal();
  std::error_code error;
  const fs::path whole = fs::canonical(path, error);
  if (error) return path;
  const fs::path within = fs::canonical(folder.empty() ? "." : folder, error);
  if (error || !stays_inside(whole.lexically_relative(within))) {
    refuse("is a link that points outside its folder");
  }
  const fs::file_type type = fs::status(whole, error).type();
  if (type != fs::file_type::regular && type != fs::file_type::directory) refuse("is not a file");
  return whole;
}

}  // namespace marco::files
