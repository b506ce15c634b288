#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace marco::files {

/// The files below a folder, relative to it, in order of name; links are not followed.
/// OutputFolder's own files are left out. Ends early when there are more than `most`.
/// @throws std::filesystem::filesystem_error.
std::vector<std::string> files_below(const std::filesystem::path& folder,
                                     std::size_t most = std::numeric_limits<std::size_t>::max());

/// Of the list: ".marco-OWNER".
std::string list_name(const std::string& owner);

/// Notes in FOLDER/.marco-OWNER which files a command wrote, with their sizes and times: later a
/// file of this list that still is as it was written is known for a result, and any other for
/// somebody's own. @param owner  the command, e.g. "map"
/// @param kept  results of an earlier run, relative to `earlier`, that are to stay in the list
void write_result_list(const std::filesystem::path& folder,
                       const std::string& owner,
                       const std::filesystem::path& earlier = {},
                       const std::vector<std::string>& kept = {});

/// The files that the list names and that were not changed since, and the list itself; empty
/// without a list.
std::vector<std::string> unchanged_results(const std::filesystem::path& folder,
                                           const std::string& owner);

}  // namespace marco::files
