#include "common/files/text_fields.hpp"

#include <cmath>
#include <stdexcept>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {

bool TextRows::next_line() {
  if (rest_.empty()) return false;
  const std::size_t end = rest_.find('\n');
  line_ = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  ++number_;
  return true;
}

bool TextRows::next() {
  while (next_line()) {
    while (!line_.empty() && TextFields::separates(line_.front())) line_.remove_prefix(1);
    if (!line_.empty() && !line_.starts_with('#') && !line_.starts_with("//")) return true;
  }
  line_ = {};
  return false;
}

std::size_t TextRows::numbers(std::span<double> into) const {
  const char* at = line_.data();
  const char* const end = at + line_.size();
  std::size_t count = 0;
  for (; count < into.size(); ++count) {
    while (at != end && TextFields::separates(*at)) ++at;
    if (at != end && *at == '+') ++at;
    const auto parsed = std::from_chars(at, end, into[count]);
    if (parsed.ec != std::errc{}) break;
    if (parsed.ptr != end && !TextFields::separates(*parsed.ptr)) break;
    at = parsed.ptr;
  }
  return count;
}

void TextRows::fail(const std::string& what) const {
  throw std::invalid_argument(place() + ": " + what);
}

std::vector<NumericRow> read_numeric_rows(const std::string& path) {
  const std::string text = read_whole_file(path);
  std::vector<NumericRow> rows;
  for (TextRows lines(text, path); lines.next_line();) {
    NumericRow row{lines.place(), {}};
    TextFields fields(lines.line().substr(0, lines.line().find('#')));
    for (std::string_view field = fields.next(); !field.empty(); field = fields.next()) {
      const auto value = TextFields(field).number<double>();
      require(value && std::isfinite(*value),
              row.place + ": '" + std::string(field.substr(0, 40)) + "' is not a finite number");
      row.numbers.push_back(*value);
    }
    if (!row.numbers.empty()) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace marco::files
