#pragma once

#include <string_view>

namespace marco::lcm_schema {

/// A word or a mark of an .lcm source.
struct Token {
  std::string_view text;  ///< empty at the end of the source
  int line = 1;
  int column = 1;
};

/// The tokens of an .lcm source in their order, without blanks and comments. Looks into the text it
/// was given, which has to live as long.
class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) { advance(); }

  const Token& peek() const { return token_; }
  Token next() {
    const Token result = token_;
    advance();
    return result;
  }

 private:
  void skip(std::size_t count);
  void skip_blanks_and_comments();
  void advance();

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
  int column_ = 1;
  Token token_;
};

}  // namespace marco::lcm_schema
