#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::files {

/// What a reader made of its input, for report.json and for a person.
struct InputReport {
  std::string format;  ///< "CARMEN log", "LCM log", ...
  std::vector<std::string> paths;
  std::map<std::string, int64_t> given;    ///< samples by kind
  std::map<std::string, int64_t> dropped;  ///< by cause
  std::map<std::string, std::string>
      places;                      ///< where each cause was met first: "line 12", "byte 4711"
  std::vector<std::string> notes;  ///< assumptions made, oddities seen

  void drop(const std::string& cause, const std::string& place) {
    if (++dropped[cause] == 1) places[cause] = place;
  }
};

/// A recording as a stream of values, in the order of its file.
class SampleReader {
 public:
  virtual ~SampleReader() = default;

  /// The next sample; nothing at the end.
  virtual std::optional<Sample> next() = 0;

  /// Complete when next() has returned nothing.
  virtual const InputReport& report() const = 0;

  /// Part of the input that was read, 0..1.
  virtual double progress() const = 0;
};

}  // namespace marco::files
