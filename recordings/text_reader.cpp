#include "recordings/text_reader.hpp"

#include <algorithm>

#include "lcm_tools/files/readable.hpp"

namespace marco::files {

TextReader::TextReader(const std::filesystem::path& path, const char* format)
    : file_(open_readable(path)) {
  std::error_code ignored;
  size_bytes_ = static_cast<double>(std::filesystem::file_size(path, ignored));
  report_.format = format;
  report_.paths = {path.string()};
}

double TextReader::progress() const {
  return size_bytes_ > 0.0 ? std::min(1.0, read_bytes_ / size_bytes_) : 1.0;
}

void TextReader::survey(const std::function<void(TextFields)>& use_line) {
  while (files::read_line(file_, text_)) use_line(TextFields(text_));
  file_.clear();
  file_.seekg(0);
}

bool TextReader::read_piece() {
  if (!files::read_line(file_, text_)) return false;
  ++line_number_;
  read_bytes_ += static_cast<double>(text_.size()) + 1.0;
  read_line(TextFields(text_));
  return true;
}

void TextReader::note_no_return(double range_m) {
  note("ranges of %.3f m and more count as no return", range_m);
}

bool read_ranges(TextFields& fields, std::vector<float>& ranges_m) {
  const auto count = fields.number<int>();
  if (!count || *count < 0 || static_cast<std::size_t>(*count) > kMaxBeams) return false;
  ranges_m.resize(static_cast<std::size_t>(*count));
  for (float& range_m : ranges_m) {
    const auto value = fields.number<float>();
    if (!value) return false;
    range_m = *value;
  }
  return true;
}

std::optional<Pose2> read_pose(TextFields& fields) {
  const auto x = fields.number<double>(), y = fields.number<double>(),
             theta = fields.number<double>();
  if (!x || !y || !theta) return std::nullopt;
  return Pose2{*x, *y, *theta};
}

}  // namespace marco::files
