#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "recordings/ros/split_recordings.hpp"

namespace marco::many {

/// A recording, and the folder of its results within that of all.
struct Entry {
  std::string name;
  RecordingParts parts;  ///< absolute paths
};

/// The recordings that arguments mean: files; in a folder, also in folders within it, every file
/// and every folder that is one; in a text file, a path a line (relative ones beside that file, #
/// begins a comment). Parts of a split recording are one.
/// @throws std::invalid_argument naming what is not there, or holds nothing.
std::vector<RecordingParts> find_recordings(const std::vector<std::filesystem::path>& arguments);

/// Adds recordings to those of an earlier run, which keep their names; a recording of which a part
/// is there already is not added. Names are those of files and folders without their endings, and a
/// number where two are alike.
std::vector<Entry> with_names(std::vector<Entry> earlier,
                              const std::vector<RecordingParts>& recordings);

/// One a line: name and paths, tabs between them. A file that is not there holds none.
std::vector<Entry> read_list(const std::filesystem::path& file);
void write_list(const std::filesystem::path& file, const std::vector<Entry>& entries);

}  // namespace marco::many
