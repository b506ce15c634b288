#include "drivers/devices/said_lines.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include "drivers/hcs12/codec.hpp"
#include "drivers/textbase/codec.hpp"

namespace marco::drivers::devices {
namespace {

constexpr std::size_t kLeastText = 8;
constexpr double kLeastPrintable = 0.95;
constexpr std::size_t kLongestExcerpt = 60;

struct Lines {
  std::vector<std::string> whole;
  std::string last;  ///< not ended yet: a prompt
};

Lines cut(std::span<const uint8_t> bytes) {
  Lines lines;
  for (const uint8_t byte : bytes) {
    if (byte == '\n') {
      lines.whole.push_back(std::move(lines.last));
      lines.last.clear();
    } else if (byte != '\r') {
      lines.last += static_cast<char>(byte);
    }
  }
  return lines;
}

bool is_printable(uint8_t byte) {
  return (byte >= ' ' && byte < 0x7F) || byte == '\n' || byte == '\r' || byte == '\t';
}

std::optional<Claim> text_base(const Lines& lines) {
  int reports = 0;
  for (const std::string& line : lines.whole) {
    const auto body = textbase::without_sum(line);
    const auto said = body ? textbase::parse_board_line(body->text) : std::nullopt;
    if (!said) continue;
    if (const auto* hello = std::get_if<textbase::Hello>(&*said)) {
      return Claim{Kind::textbase, "base with Marco's text protocol, '" + hello->name + "'"};
    }
    if (std::holds_alternative<textbase::Report>(*said)) ++reports;
  }
  if (reports < 2) return std::nullopt;
  return Claim{Kind::textbase, "base with Marco's text protocol"};
}

/// @param asked  whether it was asked: its answers have no checksum.
std::optional<Claim> thesis_board(const Lines& lines, bool asked) {
  for (const std::string& line : lines.whole) {
    // At power-on.
    if (line.starts_with("Robot ROCA-MOBILE")) {
      return Claim{Kind::hcs12_base, "base board of thesis B"};
    }
    if (line.starts_with("Sistema ROCA-PANT-TILT")) {
      return Claim{Kind::hcs12_pantilt, "pan-tilt board of thesis B"};
    }
    if (!asked) continue;
    if (hcs12::parse_wheel_status(line)) return Claim{Kind::hcs12_base, "base board of thesis B"};
    if (hcs12::parse_pantilt_status(line)) {
      return Claim{Kind::hcs12_pantilt, "pan-tilt board of thesis B"};
    }
  }
  return std::nullopt;
}

bool waits_for_a_person(const std::string& prompt) {
  if (prompt.find("ogin:") != std::string::npos) return true;
  if (prompt.find("assword:") != std::string::npos) return true;
  return prompt.size() > 2 && (prompt.ends_with("$ ") || prompt.ends_with("# "));
}

/// The newest line that holds a word.
std::string excerpt(const Lines& lines) {
  std::string text = lines.last;
  for (auto line = lines.whole.rbegin(); line != lines.whole.rend(); ++line) {
    if (line->size() >= 2) {
      text = *line;
      break;
    }
  }
  std::replace_if(
      text.begin(), text.end(), [](char c) { return !is_printable(static_cast<uint8_t>(c)); }, '?');
  if (text.size() > kLongestExcerpt) text = text.substr(0, kLongestExcerpt) + "...";
  return text;
}

}  // namespace

bool is_nmea_sentence(std::string_view line) {
  const std::size_t star = line.rfind('*');
  if (line.size() < 9 || (line[0] != '$' && line[0] != '!') || star + 3 != line.size())
    return false;
  unsigned sum = 0, said = 0;
  for (const char c : line.substr(1, star - 1)) sum ^= static_cast<uint8_t>(c);
  const char* digits = line.data() + star + 1;
  const auto read = std::from_chars(digits, digits + 2, said, 16);
  return read.ec == std::errc() && read.ptr == digits + 2 && said == sum;
}

std::optional<Claim> judge_lines(std::span<const uint8_t> bytes, Kind asked) {
  const Lines lines = cut(bytes);
  if (auto board = text_base(lines)) return board;
  if (auto board = thesis_board(lines, asked == Kind::hcs12_base)) return board;
  if (std::count_if(lines.whole.begin(), lines.whole.end(), is_nmea_sentence) >= 2) {
    return Claim{Kind::nmea, excerpt(lines)};
  }
  const auto printable = std::count_if(bytes.begin(), bytes.end(), is_printable);
  if (bytes.size() < kLeastText ||
      static_cast<double>(printable) < kLeastPrintable * static_cast<double>(bytes.size())) {
    return std::nullopt;
  }
  if (waits_for_a_person(lines.last)) return Claim{Kind::login, lines.last};
  return Claim{Kind::text, excerpt(lines)};
}

}  // namespace marco::drivers::devices
