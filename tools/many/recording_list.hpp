#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace marco::many {

/// A recording, and the folder of its results within that of all.
struct Entry {
  std::string name;
  std::filesystem::path path;  ///< absolute
};

/// The recordings that an argument means: itself; in a folder, also in folders within it, every
/// file and every folder that is one; in a text file, a path a line (relative ones beside that
/// file, # begins a comment). By name.
/// @throws std::invalid_argument naming what is not there, or holds nothing.
std::vector<std::filesystem::path> find_recordings(const std::filesystem::path& argument);

/// Adds recordings to those of an earlier run, which keep their names; a recording that is there
/// already is not added. Names are those of files and folders without their endings, and a number
/// where two are alike.
std::vector<Entry> with_names(std::vector<Entry> earlier,
                              const std::vector<std::filesystem::path>& recordings);

/// One a line: name, tab, path. A file that is not there holds none.
std::vector<Entry> read_list(const std::filesystem::path& file);
void write_list(const std::filesystem::path& file, const std::vector<Entry>& entries);

}  // namespace marco::many
