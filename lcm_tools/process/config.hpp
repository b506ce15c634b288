#pragma once

#include <toml++/toml.h>

#include <set>
#include <string>

#include "lcm_tools/base/options.hpp"

namespace marco::process {

/// Reads a TOML file. @throws std::invalid_argument with file, line, column and what was wrong.
toml::table read_toml(const std::string& path);

namespace detail {

/// The visitor that fills options from a table and remembers which keys it used.
class TomlReader {
 public:
  TomlReader(const toml::table& table, std::string path) : table_(table), path_(std::move(path)) {}

  template <class T>
  void operator()(std::string_view name, T& value, Limits limits = {}) {
    used_.insert(std::string(name));
    const toml::node* node = table_.get(name);
    if (node != nullptr) read(std::string(name), *node, value, limits);
  }
  /// @throws std::invalid_argument naming the first key nobody asked for.
  void refuse_unknown() const;

 private:
  void read(const std::string& name, const toml::node& node, double& value, Limits limits);
  void read(const std::string& name, const toml::node& node, int& value, Limits limits);
  void read(const std::string& name, const toml::node& node, bool& value, Limits limits);
  void read(const std::string& name, const toml::node& node, std::string& value, Limits limits);
  void read(const std::string& name,
            const toml::node& node,
            std::vector<double>& value,
            Limits limits);
  void read(const std::string& name,
            const toml::node& node,
            std::vector<std::string>& value,
            Limits limits);
  template <class T>
  void read(const std::string& name, const toml::node& node, std::vector<T>& values, Limits) {
    const toml::array* array = node.as_array();
    if (array == nullptr) fail(name, node, "a list of tables");
    values.clear();
    for (const toml::node& item : *array) read(name, item, values.emplace_back(), {});
  }
  template <class T>
  void read(const std::string& name, const toml::node& node, T& nested, Limits) {
    const toml::table* table = node.as_table();
    if (table == nullptr) fail(name, node, "a table");
    TomlReader reader(*table, path_ + name + ".");
    nested.visit(reader);
    reader.refuse_unknown();
  }
  [[noreturn]] void fail(const std::string& name,
                         const toml::node& node,
                         const std::string& expected) const;
  void check(const std::string& name, const toml::node& node, double value, Limits limits) const;

  const toml::table& table_;
  std::string path_;
  std::set<std::string> used_;
};

/// The visitor that prints options as TOML with their values in force.
class TomlWriter {
 public:
  template <class T>
  void operator()(std::string_view name, T& value, Limits = {}) {
    write(std::string(name), value);
  }
  toml::table take() { return std::move(table_); }

 private:
  template <class T>
  void write(const std::string& name, T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
      table_.insert(name, value);
    } else {
      TomlWriter writer;
      value.visit(writer);
      table_.insert(name, writer.take());
    }
  }
  template <class T>
  void write(const std::string& name, std::vector<T>& values) {
    toml::array array;
    for (T& value : values) {
      TomlWriter writer;
      writer.write("item", value);
      writer.table_["item"].visit([&array](auto& node) { array.push_back(node); });
    }
    table_.insert(name, std::move(array));
  }
  toml::table table_;
};

std::string to_text(const toml::table& table);

/// What of `table` is not in `other` with the same value.
toml::table difference(const toml::table& table, const toml::table& other);

}  // namespace detail

/// Fills `options` from the whole of `table`; keys that are missing keep their defaults.
/// @param name names the table in messages, e.g. the file's path.
/// @throws std::invalid_argument naming key, place and what was expected: an unknown key, a wrong
/// type, a value outside its limits.
template <class Options>
void read_options(const toml::table& table, Options& options, const std::string& name) {
  detail::TomlReader reader(table, name + ": ");
  options.visit(reader);
  reader.refuse_unknown();
}

/// Defaults, or the file's values over them. @param path "" = defaults.
template <class Options>
Options load_options(const std::string& path) {
  Options options;
  if (!path.empty()) read_options(read_toml(path), options, path);
  return options;
}

/// The options as a TOML text that read_options takes back.
template <class Options>
std::string print_options(Options options) {
  detail::TomlWriter writer;
  options.visit(writer);
  return detail::to_text(writer.take());
}

/// Those of the options that are not as the program would choose them.
template <class Options>
std::string print_changed_options(Options options) {
  Options defaults;
  detail::TomlWriter now, before;
  options.visit(now);
  defaults.visit(before);
  return detail::to_text(detail::difference(now.take(), before.take()));
}

}  // namespace marco::process
