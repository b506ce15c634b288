#include "lcm_tools/procman/process/keeper_message.hpp"

#include <charconv>
#include <map>

namespace marco::procman {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\\\";
    } else if (c == '\n') {
      out += "\\n";
    } else {
      out += c;
    }
  }
  return out;
}

std::string unescaped(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '\\' && at + 1 < text.size()) {
      ++at;
      out += text[at] == 'n' ? '\n' : text[at];
    } else {
      out += text[at];
    }
  }
  return out;
}

/// One list of the fields for both directions.
template <class Visitor>
void visit(KeeperMessage& message, Visitor&& visitor) {
  visitor("kind", message.kind);
  visitor("id", message.spec.id);
  visitor("exec", message.spec.exec);
  visitor("group", message.spec.group);
  visitor("auto_respawn", message.spec.auto_respawn);
  visitor("stop_signal", message.spec.stop_signal);
  visitor("stop_time_allowed_s", message.spec.stop_time_allowed_s);
  visitor("runid", message.runid);
  visitor("pid", message.pid);
  visitor("raw_status", message.raw_status);
  visitor.optional("cause", message.cause);
  visitor("signal", message.signal);
  visitor("allowed_s", message.allowed_s);
  visitor("output_file", message.output_file);
  visitor("output_limit", message.output_limit);
  visitor("output_inode", message.output_inode);
  visitor("output_begin", message.output_begin);
  visitor("output_end", message.output_end);
  visitor("output_shown", message.output_shown);
  visitor("output_lost", message.output_lost);
}

struct Writer {
  std::string out;

  void operator()(const char* key, const std::string& value) {
    out += std::string(key) + " " + escaped(value) + "\n";
  }
  void operator()(const char* key, bool value) { (*this)(key, std::string(value ? "1" : "0")); }
  void optional(const char* key, const std::string& value) { (*this)(key, value); }
  template <class Number>
  void operator()(const char* key, Number value) {
    char digits[64];
    const auto end = std::to_chars(digits, digits + sizeof digits, value);
    (*this)(key, std::string(digits, end.ptr));
  }
};

struct Reader {
  std::map<std::string, std::string_view, std::less<>> values;
  bool good = true;

  std::string_view value(const char* key) {
    const auto at = values.find(key);
    good = good && at != values.end();
    return at != values.end() ? at->second : std::string_view();
  }
  void operator()(const char* key, std::string& out) { out = unescaped(value(key)); }
  /// A keeper of an earlier version, which a new deputy finds at work, does not write it.
  void optional(const char* key, std::string& out) {
    if (values.contains(key)) (*this)(key, out);
  }
  void operator()(const char* key, bool& out) { out = value(key) == "1"; }
  template <class Number>
  void operator()(const char* key, Number& out) {
    const std::string_view text = value(key);
    const auto end = std::from_chars(text.data(), text.data() + text.size(), out);
    good = good && end.ec == std::errc() && end.ptr == text.data() + text.size();
  }
};

}  // namespace

std::string encode(const KeeperMessage& message) {
  Writer writer;
  KeeperMessage copy = message;
  visit(copy, writer);
  return writer.out;
}

std::optional<KeeperMessage> decode_keeper_message(std::string_view bytes) {
  Reader reader;
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    const std::size_t space = bytes.find(' ');
    if (end == std::string_view::npos || space == std::string_view::npos || space > end) {
      return std::nullopt;
    }
    reader.values[std::string(bytes.substr(0, space))] = bytes.substr(space + 1, end - space - 1);
    bytes.remove_prefix(end + 1);
  }
  KeeperMessage message;
  visit(message, reader);
  if (!reader.good) return std::nullopt;
  return message;
}

}  // namespace marco::procman
