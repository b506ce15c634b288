#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
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

/// An options struct lists the fields that a user may set, once:
///
///     struct MatcherOptions {
///       double search_radius_m = 0.3;
///       int rounds = 5;
///       RefineOptions refine;
///       template <class Visitor> void visit(Visitor& v) {
///         v("search_radius_m", search_radius_m, Limits{0.0, 10.0}, "Meaning. When to change it.");
///         v.advanced("rounds", rounds, Limits{1, 10}, "The same, for experts.");
///         v("refine", refine);
///       }
///     };
///
/// Everything else derives from that list: reading TOML, refusing unknown keys, `--print-config`
/// (lcm_tools/process/config) and validate() below. Fields: double, int, bool, std::string,
/// std::vector of double or string, nested options, std::vector of nested options. A field that is
/// not listed is for the caller in C++ alone.
///
/// This is what visits: `visit` is compiled for this one type, also for derived classes.
class OptionVisitor {
 public:
  using Field = std::
      variant<double*, int*, bool*, std::string*, std::vector<double>*, std::vector<std::string>*>;

  /// One field, as a visitor gets it.
  struct Setting {
    std::string_view name;
    Field value;
    Limits limits;
    std::string_view about;  ///< meaning, and when to change it; "" = undocumented
    bool advanced;           ///< `--print-config` shows it with `--advanced` only
  };

  virtual ~OptionVisitor() = default;

  template <class Options>
  void walk(Options& options) {
    options.visit(*this);
  }

  template <class T>
  void operator()(std::string_view name,
                  T& value,
                  Limits limits = {},
                  std::string_view about = {}) {
    if constexpr (std::is_constructible_v<Field, T*>) {
      field({name, &value, limits, about, false});
    } else {
      nested(name, value);
    }
  }
  template <class T>
  void operator()(std::string_view name, T& value, std::string_view about) {
    field({name, &value, {}, about, false});
  }
  template <class T>
  void advanced(std::string_view name, T& value, Limits limits, std::string_view about) {
    field({name, &value, limits, about, true});
  }
  template <class T>
  void advanced(std::string_view name, T& value, std::string_view about) {
    field({name, &value, {}, about, true});
  }

 protected:
  static constexpr int kNoItem = -1;

  virtual void field(const Setting& setting) = 0;
  /// Before nested options, or one item of a list of them. @returns whether they are visited.
  virtual bool enter(std::string_view name, int item) = 0;
  virtual void leave() = 0;
  /// Before a list of nested options. @returns how many items it is to have.
  virtual std::size_t enter_list(std::string_view name, std::size_t size) = 0;

 private:
  template <class Options>
  void nested(std::string_view name, Options& options, int item = kNoItem) {
    if (!enter(name, item)) return;
    walk(options);
    leave();
  }
  template <class Options>
  void nested(std::string_view name, std::vector<Options>& list) {
    list.resize(enter_list(name, list.size()));
    for (std::size_t i = 0; i < list.size(); ++i) nested(name, list[i], static_cast<int>(i));
  }
};

/// The visitor that checks limits.
class LimitsChecker final : public OptionVisitor {
 public:
  explicit LimitsChecker(const std::string& name) : path_{name + "."} {}

 protected:
  void field(const Setting& setting) override {
    if (const auto* number = std::get_if<double*>(&setting.value)) check(setting, **number);
    if (const auto* number = std::get_if<int*>(&setting.value)) check(setting, **number);
    if (const auto* numbers = std::get_if<std::vector<double>*>(&setting.value)) {
      for (const double number : **numbers) check(setting, number);
    }
  }
  bool enter(std::string_view name, int) override {
    path_.push_back(path_.back() + std::string(name) + ".");
    return true;
  }
  void leave() override { path_.pop_back(); }
  std::size_t enter_list(std::string_view, std::size_t size) override { return size; }

 private:
  void check(const Setting& setting, double value) const {
    const auto& [min, max] = setting.limits;
    require(value >= min && value <= max,
            "option " + path_.back() + std::string(setting.name) + " = " + std::to_string(value) +
                " is outside [" + std::to_string(min) + ", " + std::to_string(max) + "]");
  }
  std::vector<std::string> path_;
};

/// Called by the constructor of each algorithm. @throws std::invalid_argument naming option and
/// limits.
template <class Options>
void validate(Options options, const std::string& name) {
  LimitsChecker checker(name);
  checker.walk(options);
}

}  // namespace marco
