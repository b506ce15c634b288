#include "lcm_tools/procman/config_lexer.hpp"

#include <utility>

#include "lcm_tools/procman/characters.hpp"

namespace marco::procman {

std::string Token::description() const {
  switch (kind) {
    case TokenKind::string:
      return "string \"" + text + "\"";
    case TokenKind::identifier:
      return "'" + text + "'";
    case TokenKind::integer:
      return "integer " + text;
    case TokenKind::symbol:
      return "'" + text + "'";
    case TokenKind::end:
      break;
  }
  return "the end of the file";
}

ConfigLexer::ConfigLexer(const std::string& text, std::string file)
    : text_(text), place_{std::move(file), 1, 1} {}

char ConfigLexer::take() {
  const char c = text_[at_++];
  if (c == '\n') {
    ++place_.line;
    place_.column = 1;
  } else {
    ++place_.column;
  }
  return c;
}

void ConfigLexer::skip_space_and_comments() {
  while (at_ < text_.size()) {
    if (text_[at_] == '#') {
      while (at_ < text_.size() && text_[at_] != '\n') take();
    } else if (is_space(text_[at_])) {
      take();
    } else {
      return;
    }
  }
}

Token ConfigLexer::take_string() {
  Token token{TokenKind::string, "", place_};
  take();
  while (at_ < text_.size() && text_[at_] != '\n') {
    char c = take();
    if (c == '"') return token;
    if (c == '\\') {
      if (at_ == text_.size()) break;
      c = take();
      if (c == '\r' && at_ < text_.size() && text_[at_] == '\n') c = take();
      if (c == 'n') c = '\n';
      if (c == 'r') c = '\r';
      if (c == 't') c = '\t';
    }
    token.text += c;
  }
  throw ConfigError(
      token.place,
      "this string does not end: expected '\"' on the same line, or a backslash at the "
      "line's end");
}

Token ConfigLexer::next() {
  skip_space_and_comments();
  if (at_ == text_.size()) return {TokenKind::end, "", place_};
  const char first = text_[at_];
  if (first == '"') return take_string();
  Token token{TokenKind::symbol, "", place_};
  if (begins_name(first)) {
    token.kind = TokenKind::identifier;
    while (at_ < text_.size() && (continues_name(text_[at_]) || text_[at_] == '-'))
      token.text += take();
    return token;
  }
  if (is_digit(first)) {
    token.kind = TokenKind::integer;
    while (at_ < text_.size() && is_digit(text_[at_])) token.text += take();
    return token;
  }
  if (first == '=' || first == ';' || first == '{' || first == '}') {
    token.text = take();
    return token;
  }
  throw ConfigError(
      place_, "expected a name, an integer, a string in double quotes or one of = ; { }, got '" +
                  std::string(1, first) + "'");
}

}  // namespace marco::procman
