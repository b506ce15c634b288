#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "lcm_tools/base/check.hpp"

namespace marco {

/// Closed interval an option must lie in.
struct Limits {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

inline constexpr Limits kPositive{std::numeric_limits<double>::min(),
                                  std::numeric_limits<double>::infinity()};
inline constexpr Limits kNotNegative{0.0, std::numeric_limits<double>::infinity()};

/// An options struct lists its fields once:
///
///     struct MatcherOptions {
///       double search_radius_m = 0.3;  ///< half-width [m]
///       RefineOptions refine;
///       template <class Visitor> void visit(Visitor& v) {
///         v("search_radius_m", search_radius_m, Limits{0.0, 10.0});
///         v("refine", refine);
///       }
///     };
///
/// From that one list come reading TOML, refusing unknown keys, `--print-config`
/// (lcm_tools/process/config) and the range check below. Fields: double, int, bool, std::string,
/// std::vector of double or string, nested options, std::vector of nested options. The visitor that
/// checks limits.
class LimitsChecker {
 public:
  explicit LimitsChecker(std::string path) : path_(std::move(path)) {}

  template <class T>
  void operator()(std::string_view name, T& value, Limits limits = {}) {
    if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, std::string>) {
      return;
    } else if constexpr (std::is_arithmetic_v<T>) {
      check(name, static_cast<double>(value), limits);
    } else if constexpr (std::is_same_v<T, std::vector<double>>) {
      for (const double item : value) check(name, item, limits);
    } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
      return;
    } else {
      nested(name, value);
    }
  }

 private:
  template <class T>
  void nested(std::string_view name, T& value) {
    LimitsChecker checker(path_ + std::string(name) + ".");
    value.visit(checker);
  }
  template <class T>
  void nested(std::string_view name, std::vector<T>& values) {
    for (T& value : values) nested(name, value);
  }
  void check(std::string_view name, double value, Limits limits) const {
    require(value >= limits.min && value <= limits.max,
            "option " + path_ + std::string(name) + " = " + std::to_string(value) +
                " lies outside [" + std::to_string(limits.min) + ", " + std::to_string(limits.max) +
                "]");
  }
  std::string path_;
};

/// Called by the constructor of each algorithm. @throws std::invalid_argument naming option and
/// limits.
template <class Options>
void validate(Options options, const std::string& name) {
  LimitsChecker checker(name + ".");
  options.visit(checker);
}

}  // namespace marco
