#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace marco::process {

/// The name that a person most likely meant by `word`: the one with the fewest typing errors (a
/// letter missing, added, wrong, or two swapped), at most one error in three letters, capitals
/// aside; else the only name that begins with `word` (three letters or more). Of equals the first.
/// @returns nothing where no name is near, or where `word` is itself one of `names`.
/// Pure; safe from several threads.
std::optional<std::string> closest_name(std::string_view word,
                                        const std::vector<std::string>& names);

/// "; did you mean 'NAME'?" for the end of a message, or "" where no name is near.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& names);

}  // namespace marco::process
