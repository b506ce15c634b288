#include "lcm_tools/process/config.hpp"

#include <spdlog/spdlog.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/suggest.hpp"

namespace marco::process {
namespace {

std::string place_of(const toml::node& node) {
  const toml::source_position& at = node.source().begin;
  return "line " + std::to_string(at.line) + ", column " + std::to_string(at.column);
}

/// Looks through TOML for what its parser has no bound for: it takes memory by the value, and its
/// tables are destroyed by recursion.
class TomlBounds {
 public:
  explicit TomlBounds(const std::string& name) : name_(name) {}

  void check(std::string_view text) {
    for (std::size_t i = 0; i < text.size(); i = after(text, i)) {
      if (is_shallow_after(text[i])) continue;
      const auto line =
          1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(i), '\n');
      throw std::invalid_argument(name_ + ":" + std::to_string(line) +
                                  ": is nested deeper than 32");
    }
  }

 private:
  // Where the next thing begins: behind a comment or a string.
  static std::size_t after(std::string_view text, std::size_t at) {
    const char c = text[at];
    if (c == '#') return std::min(text.find('\n', at), text.size());
    if (c != '"' && c != '\'') return at + 1;
    const bool has_lines = text.substr(at, 3) == std::string(3, c);
    const std::string mark(has_lines ? 3 : 1, c);
    std::size_t end = at + mark.size();
    while (end < text.size() && !text.substr(end).starts_with(mark)) {
      end += c == '"' && text[end] == '\\' ? 2 : 1;
    }
    end += mark.size();
    // Two of the marks may belong to the string.
    for (int i = 0; has_lines && i < 2 && end < text.size() && text[end] == c; ++i) ++end;
    return std::min(end, text.size());
  }

  bool is_shallow_after(char c) {
    constexpr int kDeepest = 32;
    if (std::string_view("=,[]{}#\n").find(c) != std::string_view::npos) dots_ = 0;
    if (c == '[' || c == '{') ++open_;
    if (c == ']' || c == '}') --open_;
    if (c == '.') ++dots_;
    return dots_ < kDeepest && open_ < kDeepest;
  }

  const std::string& name_;
  int dots_ = 0, open_ = 0;
};

toml::table parse(const std::string& text, const std::string& name) {
  TomlBounds(name).check(text);
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    const toml::source_position& at = error.source().begin;
    throw std::invalid_argument(name + ":" + std::to_string(at.line) + ":" +
                                std::to_string(at.column) + ": " +
                                std::string(error.description()));
  }
}

/// Fills options from a table and refuses keys that none of them has.
class TomlReader final : public OptionVisitor {
 public:
  TomlReader(const toml::table& table, const std::string& name) {
    levels_.push_back({&table, name + ": "});
  }
  void refuse_unknown() const {
    const Level& level = levels_.back();
    for (const auto& [key, node] : *level.table) {
      if (level.used.contains(std::string(key.str()))) continue;
      const std::vector<std::string> names(level.used.begin(), level.used.end());
      std::string known;
      for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
      throw std::invalid_argument(level.path + "unknown key '" + std::string(key.str()) + "' (" +
                                  place_of(node) + ")" + did_you_mean(key.str(), names) +
                                  "\n  known here: " + known);
    }
  }

 protected:
  void field(const Setting& setting) override {
    const toml::node* node = use(setting.name);
    if (node == nullptr) return;
    std::visit([&](auto* target) { read(setting.name, *node, *target, setting.limits); },
               setting.value);
  }
  bool enter(std::string_view name, int item) override {
    const toml::node* node = use(name);
    if (node == nullptr) return false;
    if (item != kNoItem) node = node->as_array()->get(static_cast<std::size_t>(item));
    if (!node->is_table()) fail(name, *node, "a table");
    levels_.push_back({node->as_table(), levels_.back().path + std::string(name) + "."});
    return true;
  }
  void leave() override {
    refuse_unknown();
    levels_.pop_back();
  }
  std::size_t enter_list(std::string_view name, std::size_t size) override {
    const toml::node* node = use(name);
    if (node == nullptr) return size;
    if (!node->is_array()) fail(name, *node, "a list of tables");
    return node->as_array()->size();
  }

 private:
  struct Level {
    const toml::table* table;
    std::string path;
    std::set<std::string> used = {};
  };

  const toml::node* use(std::string_view name) {
    levels_.back().used.insert(std::string(name));
    return levels_.back().table->get(name);
  }
  [[noreturn]] void fail(std::string_view name,
                         const toml::node& node,
                         const std::string& expected) const {
    throw std::invalid_argument(levels_.back().path + std::string(name) + " (" + place_of(node) +
                                "): expected " + expected);
  }
  void check(std::string_view name, const toml::node& node, double value, Limits limits) const {
    if (value >= limits.min && value <= limits.max) return;
    std::ostringstream text;
    text << "a value ";
    if (limits.min == kPositive.min) {
      text << "> 0";
      if (std::isfinite(limits.max)) text << " and <= " << limits.max;
    } else {
      text << "within [" << limits.min << ", " << limits.max << "]";
    }
    text << ", got " << value;
    fail(name, node, text.str());
  }

  void read(std::string_view name, const toml::node& node, double& value, Limits limits) const {
    if (!node.is_number()) fail(name, node, "a number");
    value =
        node.is_integer() ? static_cast<double>(**node.as_integer()) : **node.as_floating_point();
    check(name, node, value, limits);
  }
  void read(std::string_view name, const toml::node& node, int& value, Limits limits) const {
    if (!node.is_integer()) fail(name, node, "a whole number");
    const int64_t number = **node.as_integer();
    check(name, node, static_cast<double>(number),
          {std::max(limits.min, -2147483648.0), std::min(limits.max, 2147483647.0)});
    value = static_cast<int>(number);
  }
  void read(std::string_view name, const toml::node& node, bool& value, Limits) const {
    if (!node.is_boolean()) fail(name, node, "true or false");
    value = **node.as_boolean();
  }
  void read(std::string_view name, const toml::node& node, std::string& value, Limits) const {
    if (!node.is_string()) fail(name, node, "a string in quotes");
    value = **node.as_string();
    // A config may come from elsewhere: files it makes us write elsewhere are worth a warning.
    const bool is_file = name.ends_with("_path") || name.ends_with("_folder");
    if (is_file && !files::stays_inside(value)) {
      spdlog::warn("{}{} = \"{}\" is outside the working folder", levels_.back().path, name, value);
    }
  }
  template <class T>
  void read(std::string_view name,
            const toml::node& node,
            std::vector<T>& values,
            Limits limits) const {
    const toml::array* array = node.as_array();
    if (array == nullptr) {
      fail(name, node, std::is_same_v<T, double> ? "a list of numbers" : "a list of strings");
    }
    values.clear();
    for (const toml::node& item : *array) read(name, item, values.emplace_back(), limits);
  }

  std::vector<Level> levels_;
};

void fill(const toml::table& table, const std::string& name, const detail::Fields& fields) {
  TomlReader reader(table, name);
  fields(reader);
  reader.refuse_unknown();
}

}  // namespace

namespace detail {

void read_file(const std::string& path, const Fields& fields) {
  constexpr int64_t kMostBytes = 4 << 20;
  fill(parse(files::read_whole_file(path, kMostBytes), path), path, fields);
}

void read_text(const std::string& toml, const std::string& name, const Fields& fields) {
  fill(parse(toml, name), name, fields);
}

}  // namespace detail
}  // namespace marco::process
