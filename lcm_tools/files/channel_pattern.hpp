#pragma once

#include <memory>
#include <string>

namespace marco {

/// A POSIX extended regular expression over a whole channel name. Copies share what was compiled.
/// Const: safe from several threads.
class ChannelPattern {
 public:
  enum class Case { matters, ignored };

  /// @throws std::invalid_argument quoting `text` and saying what is wrong with it.
  explicit ChannelPattern(const std::string& text, Case letters = Case::matters);

  bool matches(const std::string& channel) const;

 private:
  struct Compiled;  // a std::regex, whose templates cost seconds of every file that sees them
  std::shared_ptr<const Compiled> compiled_;
};

}  // namespace marco
