#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace marco::procman {

/// An exec string ready for execvpe.
struct ExecLine {
  std::vector<std::pair<std::string, std::string>> assignments;  ///< NAME, value
  std::vector<std::string> arguments;                            ///< the program first
};

/// A variable of the deputy's environment; none = not set.
using VariableReader = std::function<std::optional<std::string>(const std::string& name)>;

/// Splits and expands as the public procman's deputy does; it is no shell. A backslash takes the
/// next character as it is (also within quotes), '...' and "..." group, white space separates.
/// Leading words with '=' are assignments, their values are not expanded. In the other words $NAME
/// and ${NAME} of `variable` are replaced; unknown ones stay, for an inner shell to see.
/// Differences: a last word of one character, empty quoted words and empty values survive.
ExecLine parse_exec_line(const std::string& exec, const VariableReader& variable);

/// Splits only.
std::vector<std::string> split_words(const std::string& exec);

/// Whether every word is NAME=value with NAME of letters, digits and '_', not beginning by a digit.
bool is_only_assignments(const std::string& text);

/// `word` in double quotes, so that split_words gives it back.
std::string quote_word(const std::string& word);

}  // namespace marco::procman
