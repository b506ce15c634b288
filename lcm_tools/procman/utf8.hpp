#pragma once

#include <string>
#include <string_view>

namespace marco::procman {

/// Makes the bytes of a stream fit for an LCM string: valid UTF-8 without NUL. What is not becomes
/// U+FFFD, a byte at a time; a character cut by the end of a piece waits for the next piece.
class Utf8Cleaner {
 public:
  std::string clean(std::string_view piece);

  /// The bytes still waiting for more, as U+FFFD.
  std::string flush();

 private:
  std::string waiting_;
};

}  // namespace marco::procman
