#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace marco::process {

/// The name that the user most likely meant by `word`: the one with the smallest edit distance (a
/// letter missing, added, wrong, or two swapped), at most one error in three letters, ignoring
/// case; else the only name that begins with `word` (three letters or more). Ties: the first.
/// @returns nothing when no name is close, or when `word` is itself one of `names`
/// Pure; safe from several threads.
std::optional<std::string> closest_name(std::string_view word,
                                        const std::vector<std::string>& names);

/// "; did you mean 'NAME'?" for the end of a message, or "" when no name is close.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& names);

}  // namespace marco::process
