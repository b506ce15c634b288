#include "lcm_tools/process/suggest.hpp"

#include <algorithm>
#include <cctype>

namespace marco::process {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](char letter) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  });
  return result;
}

// Damerau's distance in its restricted form: no letter is part of two errors.
std::size_t typing_errors(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> errors(a.size() + 1,
                                               std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) errors[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) errors[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      errors[i][j] = std::min({errors[i - 1][j] + 1, errors[i][j - 1] + 1,
                               errors[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        errors[i][j] = std::min(errors[i][j], errors[i - 2][j - 2] + 1);
      }
    }
  }
  return errors[a.size()][b.size()];
}

}  // namespace

std::optional<std::string> closest_name(std::string_view word,
                                        const std::vector<std::string>& names) {
  constexpr std::size_t kLongestWord = 100;  // the cost grows with its square
  constexpr std::size_t kShortestBeginning = 3;
  if (word.empty() || word.size() > kLongestWord) return std::nullopt;
  const std::string typed = lower(word);
  const std::string* best = nullptr;
  const std::string* begun = nullptr;
  std::size_t begun_count = 0;
  std::size_t fewest = std::max<std::size_t>(1, typed.size() / 3) + 1;
  for (const std::string& name : names) {
    if (name == word) return std::nullopt;
    if (name.size() > kLongestWord) continue;
    const std::string known = lower(name);
    const std::size_t errors = typing_errors(typed, known);
    if (errors < fewest && errors < known.size()) {
      fewest = errors;
      best = &name;
    }
    if (known.starts_with(typed)) {
      begun = &name;
      ++begun_count;
    }
  }
  if (best == nullptr && begun_count == 1 && typed.size() >= kShortestBeginning) best = begun;
  return best == nullptr ? std::nullopt : std::optional(*best);
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& names) {
  const std::optional<std::string> name = closest_name(word, names);
  return name ? "; did you mean '" + *name + "'?" : "";
}

}  // namespace marco::process
