#include "drivers/textbase/codec.hpp"

#include <charconv>
#include <vector>

#include "lcm_tools/base/format.hpp"

namespace marco::drivers::textbase {
namespace {

constexpr std::size_t kSumSize = 3;  // *HH

unsigned sum_of(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  return sum;
}

template <class Number>
bool read(std::string_view word, Number& number, int base = 10) {
  const char* const end = word.data() + word.size();
  const auto [stopped, error] = std::from_chars(word.data(), end, number, base);
  return !word.empty() && error == std::errc() && stopped == end;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t space = text.find(' ');
    words.push_back(text.substr(0, space));
    if (space == std::string_view::npos) return words;
    text.remove_prefix(space + 1);
  }
}

std::optional<BoardLine> read_hello(const std::vector<std::string_view>& words) {
  constexpr std::string_view kKey = "wd=";
  Hello hello;
  if (words.size() != 5 || !words[4].starts_with(kKey) || words[2].empty() || words[3].empty() ||
      !read(words[1], hello.protocol) || !read(words[4].substr(kKey.size()), hello.watchdog_ms)) {
    return std::nullopt;
  }
  hello.name = words[2];
  hello.firmware = words[3];
  return hello;
}

std::optional<BoardLine> read_report(const std::vector<std::string_view>& words) {
  Report report;
  if (words.size() != 5 || !read(words[1], report.board_ms) || !read(words[2], report.left_ticks) ||
      !read(words[3], report.right_ticks) || !read(words[4], report.flags)) {
    return std::nullopt;
  }
  return report;
}

std::string numbers(const char* letter, std::initializer_list<int64_t> values) {
  std::string text = letter;
  for (const int64_t value : values) text += ' ' + std::to_string(value);
  return text;
}

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

}  // namespace

std::string with_sum(std::string_view text) {
  return std::string(text) + format("*%02X", sum_of(text));
}

std::optional<Body> without_sum(std::string_view line) {
  const std::size_t star = line.rfind('*');
  if (star == std::string_view::npos) return Body{line, false};
  unsigned sum = 0;
  if (line.size() - star != kSumSize || !read(line.substr(star + 1), sum, 16)) return std::nullopt;
  if (sum != sum_of(line.substr(0, star))) return std::nullopt;
  return Body{line.substr(0, star), true};
}

std::optional<BoardLine> parse_board_line(std::string_view text) {
  const std::vector<std::string_view> words = words_of(text);
  if (words[0] == "V") return read_hello(words);
  if (words[0] == "T") return read_report(words);
  if (words[0] == "K" && words.size() == 3 && (words[1] == "W" || words[1] == "R")) {
    Done done{words[1][0], 0};
    if (read(words[2], done.value_ms)) return done;
  }
  if (words[0] == "B" && words.size() == 2) {
    Battery battery;
    if (read(words[1], battery.millivolts)) return battery;
  }
  if (words[0] == "E" && words.size() >= 3) {
    Complaint complaint;
    complaint.text = text.substr(words[0].size() + words[1].size() + 2);
    if (read(words[1], complaint.number)) return complaint;
  }
  return std::nullopt;
}

std::string encode(const BoardLine& line) {
  return std::visit(
      Overloaded{[](const Hello& hello) {
                   return numbers("V", {hello.protocol}) + ' ' + hello.name + ' ' + hello.firmware +
                          " wd=" + std::to_string(hello.watchdog_ms);
                 },
                 [](const Done& done) {
                   return std::string("K ") + done.setting + ' ' + std::to_string(done.value_ms);
                 },
                 [](const Report& report) {
                   return numbers(
                       "T", {report.board_ms, report.left_ticks, report.right_ticks, report.flags});
                 },
                 [](const Battery& battery) { return numbers("B", {battery.millivolts}); },
                 [](const Complaint& complaint) {
                   return numbers("E", {complaint.number}) + ' ' + complaint.text;
                 }},
      line);
}

std::optional<HostLine> parse_host_line(std::string_view text) {
  if (text == "V?") return WhoAreYou{};
  const std::vector<std::string_view> words = words_of(text);
  Motion motion;
  if (words[0] == "M" && words.size() == 3 && read(words[1], motion.left_ticks_per_s) &&
      read(words[2], motion.right_ticks_per_s)) {
    return motion;
  }
  int ms = 0;
  if (words.size() != 2 || !read(words[1], ms)) return std::nullopt;
  if (words[0] == "W") return SetWatchdog{ms};
  if (words[0] == "R") return SetReports{ms};
  return std::nullopt;
}

std::string encode(const HostLine& line) {
  return std::visit(
      Overloaded{[](const WhoAreYou&) { return std::string("V?"); },
                 [](const Motion& motion) {
                   return numbers("M", {motion.left_ticks_per_s, motion.right_ticks_per_s});
                 },
                 [](const SetWatchdog& watchdog) { return numbers("W", {watchdog.ms}); },
                 [](const SetReports& reports) { return numbers("R", {reports.ms}); }},
      line);
}

}  // namespace marco::drivers::textbase
