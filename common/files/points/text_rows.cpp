#include "common/files/points/text_rows.hpp"

#include <charconv>
#include <stdexcept>

namespace marco::files {

bool TextRows::next() {
  while (!rest_.empty()) {
    const std::size_t end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++number_;
    while (!line_.empty() && separates_fields(line_.front())) line_.remove_prefix(1);
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
    while (at != end && separates_fields(*at)) ++at;
    if (at != end && *at == '+') ++at;
    const auto parsed = std::from_chars(at, end, into[count]);
    if (parsed.ec != std::errc{}) break;
    if (parsed.ptr != end && !separates_fields(*parsed.ptr)) break;
    at = parsed.ptr;
  }
  return count;
}

void TextRows::fail(const std::string& what) const {
  throw std::invalid_argument(*name_ + ":" + std::to_string(number_) + ": " + what);
}

}  // namespace marco::files
