#pragma once

/// Kinds of characters; `isspace` and its like depend on the locale, the grammar and exec strings
/// do not.
namespace marco::procman {

inline bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// Of a name: letters and `_` begin it, digits may follow.
inline bool begins_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
inline bool continues_name(char c) { return begins_name(c) || is_digit(c); }

}  // namespace marco::procman
