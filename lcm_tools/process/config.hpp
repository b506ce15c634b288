#pragma once

#include <functional>
#include <string>

#include "lcm_tools/base/options.hpp"

namespace marco::process {

/// Which settings of a configuration are printed.
enum class Printed {
  all,
  common,  ///< without the advanced ones that have their default
  changed  ///< those that differ from their default
};

namespace detail {

/// Walks an options struct's fields with the visitor it is given.
using Fields = std::function<void(OptionVisitor&)>;

template <class Options>
Fields fields_of(Options& options) {
  return [&options](OptionVisitor& visitor) { visitor.walk(options); };
}

void read_file(const std::string& path, const Fields& fields);
void read_text(const std::string& toml, const std::string& name, const Fields& fields);
std::string print(const Fields& fields, const Fields& defaults, Printed which);

}  // namespace detail

/// Fills `options` from a TOML file; keys that are missing keep their values.
/// @throws std::invalid_argument naming file, line and column, key and what was expected: no TOML,
/// an unknown key, a wrong type, a value outside its limits.
template <class Options>
void read_options(const std::string& path, Options& options) {
  detail::read_file(path, detail::fields_of(options));
}

/// The same from text. @param name  stands for the file in messages.
template <class Options>
void parse_options(const std::string& toml, Options& options, const std::string& name) {
  detail::read_text(toml, name, detail::fields_of(options));
}

/// Defaults, or the file's values over them. @param path "" = defaults.
template <class Options>
Options load_options(const std::string& path) {
  Options options;
  if (!path.empty()) read_options(path, options);
  return options;
}

/// The options as a TOML text that parse_options takes back, each with what it is.
template <class Options>
std::string print_options(Options options, Printed which = Printed::all) {
  Options defaults;
  return detail::print(detail::fields_of(options), detail::fields_of(defaults), which);
}

}  // namespace marco::process
