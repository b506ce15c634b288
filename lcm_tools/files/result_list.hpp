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

/// Lists in FOLDER/.marco-OWNER the files that a command wrote, with sizes and times. A listed file
/// that is unchanged is a result; any other belongs to the user.
/// @param owner  the command, e.g. "map"
/// @param kept   results of an earlier run, relative to `earlier`, that stay in the list
void write_result_list(const std::filesystem::path& folder,
                       const std::string& owner,
                       const std::filesystem::path& earlier = {},
                       const std::vector<std::string>& kept = {});

/// The listed files that are unchanged, and the list itself; empty without a list.
std::vector<std::string> unchanged_results(const std::filesystem::path& folder,
                                           const std::string& owner);

}  // namespace marco::files
