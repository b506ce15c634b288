#include "lcm_tools/schema/parser.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

namespace marco::lcm_schema {
namespace {

constexpr int64_t kMaxElements = int64_t{1} << 31U;
constexpr std::size_t kMaxDimensions = 16;

bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-' ||
         c == '+';
}

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

struct Mistake {
  Token where;
  std::string what;
};

std::optional<Primitive> primitive_named(std::string_view name) {
  for (int i = 0; i <= static_cast<int>(Primitive::byte); ++i) {
    if (name == name_of(static_cast<Primitive>(i))) return static_cast<Primitive>(i);
  }
  return {};
}

bool is_integer(const std::optional<Primitive>& type) { return type && *type <= Primitive::int64; }

bool is_name(std::string_view text) {
  return !text.empty() &&
         (std::isalpha(static_cast<unsigned char>(text[0])) != 0 || text[0] == '_') &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
         });
}

// Names joined by single dots.
bool is_type_name(std::string_view text) {
  while (true) {
    const std::size_t dot = text.find('.');
    if (!is_name(text.substr(0, dot))) return false;
    if (dot == std::string_view::npos) return true;
    text.remove_prefix(dot + 1);
  }
}

class Parser {
 public:
  Parser(const Source& source, std::vector<Problem>& problems)
      : source_(source), problems_(problems), tokens_(source.text) {}

  std::vector<Structure> parse() {
    while (!tokens_.peek().text.empty()) {
      try {
        parse_declaration();
      } catch (const Mistake& mistake) {
        problems_.push_back({source_.name + ":" + std::to_string(mistake.where.line) + ":" +
                             std::to_string(mistake.where.column) + ": " + mistake.what});
        recover();
      }
    }
    return std::move(structures_);
  }

 private:
  [[noreturn]] static void fail(const Token& where, const std::string& what) {
    throw Mistake{where, where.text.empty()
                             ? "the file ends, " + what
                             : what + ", got '" + std::string(where.text.substr(0, 40)) + "'"};
  }

  void expect(std::string_view text, const char* after) {
    if (tokens_.peek().text != text) {
      fail(tokens_.peek(), "expected '" + std::string(text) + "' " + after);
    }
    tokens_.next();
  }

  bool accept(std::string_view text) {
    if (tokens_.peek().text != text) return false;
    tokens_.next();
    return true;
  }

  // Behind the declaration that went wrong: at the next word that opens one at a line's beginning.
  void recover() {
    while (!tokens_.peek().text.empty()) {
      const std::string_view text = tokens_.peek().text;
      if (text == "struct" || text == "package" || text == "enum") return;
      tokens_.next();
    }
  }

  void parse_declaration() {
    const Token token = tokens_.next();
    if (token.text == "package") {
      const Token name = tokens_.next();
      if (!is_type_name(name.text)) fail(name, "expected the package's name");
      package_ = std::string(name.text) + ".";
      expect(";", "after the package's name");
    } else if (token.text == "struct") {
      parse_struct();
    } else if (token.text == "enum") {
      parse_enum();
    } else if (token.text != ";") {
      fail(token, "expected 'package', 'struct' or 'enum'");
    }
  }

  Structure open_declaration(const char* kind) {
    const Token name = tokens_.next();
    if (!is_type_name(name.text)) fail(name, std::string("expected the name of the ") + kind);
    Structure result;
    result.name = name.text.find('.') == std::string_view::npos ? package_ + std::string(name.text)
                                                                : std::string(name.text);
    result.source = source_.name;
    result.line = name.line;
    expect("{", "after the name");
    return result;
  }

  void parse_enum() {
    Structure result = open_declaration("enum");
    result.is_enum = true;
    int64_t value = 0;
    while (!accept("}")) {
      const Token name = tokens_.next();
      if (!is_name(name.text)) fail(name, "expected a value's name");
      if (accept("=")) value = integer(tokens_.next());
      result.constants.push_back({std::string(name.text), "int32_t", std::to_string(value++)});
      if (!accept(",") && !accept(";") && tokens_.peek().text != "}") {
        fail(tokens_.peek(), "expected ',' or '}' after the value");
      }
    }
    structures_.push_back(std::move(result));
  }

  void parse_struct() {
    Structure result = open_declaration("struct");
    while (!accept("}")) {
      if (accept("const")) {
        parse_constants(result);
      } else if (!accept(";")) {
        parse_members(result);
      }
    }
    structures_.push_back(std::move(result));
  }

  static void refuse_second(const Structure& structure, const Token& name) {
    if (!is_name(name.text)) fail(name, "expected the field's name");
    const auto same = [&](const auto& other) { return other.name == name.text; };
    if (std::any_of(structure.members.begin(), structure.members.end(), same) ||
        std::any_of(structure.constants.begin(), structure.constants.end(), same)) {
      fail(name, "this name is already taken in the struct");
    }
  }

  void parse_constants(Structure& structure) {
    const Token type = tokens_.next();
    const auto primitive = primitive_named(type.text);
    if (!primitive || *primitive > Primitive::float64) {
      fail(type, "expected a number's type after 'const'");
    }
    do {
      const Token name = tokens_.next();
      refuse_second(structure, name);
      expect("=", "after the constant's name");
      const Token value = tokens_.next();
      if (is_integer(primitive)) {
        integer(value);
      } else {
        number(value);
      }
      structure.constants.push_back(
          {std::string(name.text), std::string(type.text), std::string(value.text)});
    } while (accept(","));
    expect(";", "after the constant");
  }

  void parse_members(Structure& structure) {
    const Token type = tokens_.next();
    if (!is_type_name(type.text)) fail(type, "expected a field's type or '}'");
    do {
      const Token name = tokens_.next();
      refuse_second(structure, name);
      Member member;
      member.name = name.text;
      member.primitive = primitive_named(type.text);
      member.type = type.text;
      if (!member.primitive && type.text.find('.') == std::string_view::npos) {
        member.type = package_ + member.type;
      }
      while (accept("[")) member.dimensions.push_back(parse_dimension(structure));
      if (member.dimensions.size() > kMaxDimensions) fail(name, "more than 16 dimensions");
      structure.members.push_back(std::move(member));
    } while (accept(","));
    expect(";", "after the field");
  }

  Dimension parse_dimension(const Structure& structure) {
    const Token size = tokens_.next();
    Dimension result;
    result.size = size.text;
    const auto named = [&](const auto& other) { return other.name == size.text; };
    const auto member = std::find_if(structure.members.begin(), structure.members.end(), named);
    const auto constant =
        std::find_if(structure.constants.begin(), structure.constants.end(), named);
    if (member != structure.members.end()) {
      if (!is_integer(member->primitive) || !member->dimensions.empty()) {
        fail(size, "an array's length must be a single integer");
      }
      result.member = static_cast<int>(member - structure.members.begin());
    } else {
      const bool is_constant = constant != structure.constants.end();
      if (!is_constant &&
          (size.text.empty() || std::isdigit(static_cast<unsigned char>(size.text[0])) == 0)) {
        fail(size, "expected a number or an integer field declared before");
      }
      if (is_constant && constant->type.find("int") == std::string::npos) {
        fail(size, "an array's length must be an integer");
      }
      // As lcm-gen: an array sized by a constant is one sized by the constant's value.
      if (is_constant) result.size = constant->value;
      result.constant = integer({result.size, size.line, size.column});
      if (result.constant <= 0 || result.constant > kMaxElements) {
        fail(size, "an array's length must be 1 to 2^31");
      }
    }
    expect("]", "after the array's length");
    return result;
  }

  static int64_t integer(const Token& token) {
    const std::string text(token.text);
    char* end = nullptr;
    errno = 0;
    const long long value = std::strtoll(text.c_str(), &end, 0);
    if (text.empty() || *end != '\0' || errno != 0) fail(token, "expected an integer");
    return value;
  }

  static void number(const Token& token) {
    const std::string text(token.text);
    char* end = nullptr;
    std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0') fail(token, "expected a number");
  }

  const Source& source_;
  std::vector<Problem>& problems_;
  Tokens tokens_;
  std::string package_;
  std::vector<Structure> structures_;
};

}  // namespace

std::vector<Structure> parse_source(const Source& source, std::vector<Problem>& problems) {
  return Parser(source, problems).parse();
}

}  // namespace marco::lcm_schema
