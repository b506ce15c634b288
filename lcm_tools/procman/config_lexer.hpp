#pragma once

#include <string>

#include "lcm_tools/procman/config.hpp"

namespace marco::procman {

enum class TokenKind { identifier, string, integer, symbol, end };

struct Token {
  TokenKind kind = TokenKind::end;
  std::string text;  ///< of strings: unescaped
  SourcePlace place;

  /// For messages: `string "lidar"`, `'}'`, `the end of the file`.
  std::string description() const;
};

/// Cuts a procman file into tokens, one at a time.
class ConfigLexer {
 public:
  ConfigLexer(const std::string& text, std::string file);

  /// @throws ConfigError at a character that begins no token, or a string that does not end.
  Token next();

 private:
  char take();
  void skip_space_and_comments();
  Token take_string();

  const std::string& text_;
  std::size_t at_ = 0;
  SourcePlace place_;
};

}  // namespace marco::procman
