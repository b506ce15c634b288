#include "lcm_tools/process/config.hpp"

#include <spdlog/spdlog.h>

#include <charconv>
#include <cstdlib>
#include <regex>
#include <sstream>

#include "lcm_tools/files/folder_journal.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/files/readable.hpp"
#include "lcm_tools/process/suggest.hpp"

namespace marco::process {
namespace {

std::string place_of(const toml::node& node) {
  const toml::source_position& at = node.source().begin;
  return "line " + std::to_string(at.line) + ", column " + std::to_string(at.column);
}

// toml++ prints 17 digits; the shortest text that reads back the same is what a person typed.
std::string with_short_numbers(const std::string& text) {
  static const std::regex kLongNumber("-?[0-9]+\\.[0-9]{9,}(e[-+]?[0-9]+)?");
  std::string result;
  auto at = text.cbegin();
  for (std::sregex_iterator found(text.begin(), text.end(), kLongNumber), end; found != end;
       ++found) {
    char digits[32];
    const double value = std::strtod(found->str().c_str(), nullptr);
    const auto written = std::to_chars(digits, digits + sizeof digits, value);
    result.append(at, (*found)[0].first).append(digits, written.ptr);
    at = (*found)[0].second;
  }
  return result.append(at, text.cend());
}

}  // namespace

toml::table read_toml(const std::string& path) {
  files::finish_interrupted(std::filesystem::path(path).parent_path());
  files::require_readable(path);
  try {
    return toml::parse_file(path);
  } catch (const toml::parse_error& error) {
    const toml::source_position& at = error.source().begin;
    throw std::invalid_argument(path + ":" + std::to_string(at.line) + ":" +
                                std::to_string(at.column) + ": " +
                                std::string(error.description()));
  }
}

namespace detail {

void TomlReader::refuse_unknown() const {
  for (const auto& [key, node] : table_) {
    if (used_.contains(std::string(key.str()))) continue;
    const std::vector<std::string> names(used_.begin(), used_.end());
    std::string known;
    for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
    throw std::invalid_argument(path_ + "unknown key '" + std::string(key.str()) + "' (" +
                                place_of(node) + ")" + did_you_mean(key.str(), names) +
                                "\n  known here: " + known);
  }
}

void TomlReader::fail(const std::string& name,
                      const toml::node& node,
                      const std::string& expected) const {
  throw std::invalid_argument(path_ + name + " (" + place_of(node) + "): expected " + expected);
}

void TomlReader::check(const std::string& name,
                       const toml::node& node,
                       double value,
                       Limits limits) const {
  if (value >= limits.min && value <= limits.max) return;
  std::ostringstream text;
  text << "a value within [" << limits.min << ", " << limits.max << "], got " << value;
  fail(name, node, text.str());
}

void TomlReader::read(const std::string& name,
                      const toml::node& node,
                      double& value,
                      Limits limits) {
  if (!node.is_number()) fail(name, node, "a number");
  value = node.is_integer() ? static_cast<double>(**node.as_integer()) : **node.as_floating_point();
  check(name, node, value, limits);
}

void TomlReader::read(const std::string& name, const toml::node& node, int& value, Limits limits) {
  if (!node.is_integer()) fail(name, node, "a whole number");
  const int64_t number = **node.as_integer();
  check(name, node, static_cast<double>(number),
        {std::max(limits.min, -2147483648.0), std::min(limits.max, 2147483647.0)});
  value = static_cast<int>(number);
}

void TomlReader::read(const std::string& name, const toml::node& node, bool& value, Limits) {
  if (!node.is_boolean()) fail(name, node, "true or false");
  value = **node.as_boolean();
}

void TomlReader::read(const std::string& name, const toml::node& node, std::string& value, Limits) {
  if (!node.is_string()) fail(name, node, "a text in quotes");
  value = **node.as_string();
  // A config may come from elsewhere: what it makes us write is not hidden.
  const bool is_file = name.ends_with("_path") || name.ends_with("_folder");
  if (is_file && !files::stays_inside(value)) {
    spdlog::warn("{}{} = \"{}\" lies outside of the working folder", path_, name, value);
  }
}

void TomlReader::read(const std::string& name,
                      const toml::node& node,
                      std::vector<double>& value,
                      Limits limits) {
  const toml::array* array = node.as_array();
  if (array == nullptr) fail(name, node, "a list of numbers");
  value.clear();
  for (const toml::node& item : *array) read(name, item, value.emplace_back(), limits);
}

void TomlReader::read(const std::string& name,
                      const toml::node& node,
                      std::vector<std::string>& value,
                      Limits limits) {
  const toml::array* array = node.as_array();
  if (array == nullptr) fail(name, node, "a list of texts");
  value.clear();
  for (const toml::node& item : *array) read(name, item, value.emplace_back(), limits);
}

toml::table difference(const toml::table& table, const toml::table& other) {
  toml::table result;
  for (const auto& [key, node] : table) {
    const toml::node* before = other.get(key.str());
    if (node.is_table()) {
      const bool nested = before != nullptr && before->is_table();
      toml::table inner =
          difference(*node.as_table(), nested ? *before->as_table() : toml::table{});
      if (!inner.empty()) result.insert(key, std::move(inner));
      continue;
    }
    toml::table a, b;
    a.insert(key, node);
    if (before != nullptr) b.insert(key, *before);
    if (a != b) result.insert(key, node);
  }
  return result;
}

std::string to_text(const toml::table& table) {
  std::ostringstream text;
  text << table << "\n";
  return with_short_numbers(text.str());
}

}  // namespace detail
}  // namespace marco::process
