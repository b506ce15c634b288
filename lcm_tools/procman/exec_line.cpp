#include "lcm_tools/procman/exec_line.hpp"

#include <algorithm>

#include "lcm_tools/procman/characters.hpp"

namespace marco::procman {
namespace {

std::size_t end_of_name(const std::string& text, std::size_t begin) {
  std::size_t end = begin;
  if (end < text.size() && begins_name(text[end])) {
    while (end < text.size() && continues_name(text[end])) ++end;
  }
  return end;
}

std::string expand(const std::string& word, const VariableReader& variable) {
  std::string out;
  for (std::size_t at = 0; at < word.size();) {
    if (word[at] != '$') {
      out += word[at++];
      continue;
    }
    const bool braces = at + 1 < word.size() && word[at + 1] == '{';
    const std::size_t begin = at + (braces ? 2 : 1);
    const std::size_t end = end_of_name(word, begin);
    const bool whole = end > begin && (!braces || (end < word.size() && word[end] == '}'));
    const std::optional<std::string> value =
        whole ? variable(word.substr(begin, end - begin)) : std::nullopt;
    if (value) {
      out += *value;
      at = end + (braces ? 1 : 0);
    } else {
      out += word[at++];
    }
  }
  return out;
}

}  // namespace

std::vector<std::string> split_words(const std::string& exec) {
  std::vector<std::string> words;
  std::string word;
  bool in_word = false;
  char quote = 0;
  for (std::size_t at = 0; at < exec.size(); ++at) {
    const char c = exec[at];
    if (c == '\\' && at + 1 < exec.size()) {
      word += exec[++at];
      in_word = true;
    } else if (quote != 0 ? c == quote : (c == '"' || c == '\'')) {
      quote = quote != 0 ? '\0' : c;
      in_word = true;
    } else if (quote == 0 && is_space(c)) {
      if (in_word) words.push_back(std::move(word));
      word.clear();
      in_word = false;
    } else {
      word += c;
      in_word = true;
    }
  }
  if (in_word) words.push_back(std::move(word));
  return words;
}

ExecLine parse_exec_line(const std::string& exec, const VariableReader& variable) {
  ExecLine line;
  for (const std::string& word : split_words(exec)) {
    const std::size_t equals = word.find('=');
    if (line.arguments.empty() && equals != std::string::npos) {
      line.assignments.emplace_back(word.substr(0, equals), word.substr(equals + 1));
    } else {
      line.arguments.push_back(expand(word, variable));
    }
  }
  return line;
}

bool is_only_assignments(const std::string& text) {
  const std::vector<std::string> words = split_words(text);
  return std::all_of(words.begin(), words.end(), [](const std::string& word) {
    const std::size_t end = end_of_name(word, 0);
    return end > 0 && end < word.size() && word[end] == '=';
  });
}

std::string quote_word(const std::string& word) {
  std::string out = "\"";
  for (const char c : word) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

}  // namespace marco::procman
