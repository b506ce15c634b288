#include "lcm_tools/schema/tokens.hpp"

#include <algorithm>
#include <cctype>

namespace marco::lcm_schema {
namespace {

bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-' ||
         c == '+';
}

}  // namespace

void Tokens::skip(std::size_t count) {
  for (; count > 0 && at_ < text_.size(); --count, ++at_) {
    column_ = text_[at_] == '\n' ? 1 : column_ + 1;
    line_ += text_[at_] == '\n' ? 1 : 0;
  }
}

void Tokens::skip_blanks_and_comments() {
  while (at_ < text_.size()) {
    if (std::isspace(static_cast<unsigned char>(text_[at_])) != 0) {
      skip(1);
    } else if (text_.substr(at_, 2) == "//") {
      skip(std::min(text_.find('\n', at_), text_.size()) - at_);
    } else if (text_.substr(at_, 2) == "/*") {
      const std::size_t end = text_.find("*/", at_ + 2);
      skip(end == std::string_view::npos ? text_.size() - at_ : end + 2 - at_);
    } else {
      return;
    }
  }
}

void Tokens::advance() {
  skip_blanks_and_comments();
  std::size_t length = at_ < text_.size() ? 1 : 0;
  if (length == 1 && is_word(text_[at_])) {
    while (at_ + length < text_.size() && is_word(text_[at_ + length])) ++length;
  }
  token_ = {text_.substr(at_, length), line_, column_};
  skip(length);
}

}  // namespace marco::lcm_schema
