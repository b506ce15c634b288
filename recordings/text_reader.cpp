#include "recordings/text_reader.hpp"

#include <algorithm>

#include "lcm_tools/files/readable.hpp"
#include "recordings/looking_through.hpp"
#include "recordings/ros/byte_file.hpp"

namespace marco::files {

TextReader::TextReader(const std::filesystem::path& path, const char* format)
    : path_(path.string()), file_(open_readable(path)) {
  std::error_code ignored;
  size_bytes_ = static_cast<double>(std::filesystem::file_size(path, ignored));
  report_.format = format;
  report_.paths = {path.string()};
}

double TextReader::progress() const {
  return size_bytes_ > 0.0 ? std::min(1.0, read_bytes_ / size_bytes_) : 1.0;
}

void TextReader::survey(const std::function<void(TextFields)>& use_line) {
  LookingThrough progress(path_);
  while (next_line()) {
    use_line(TextFields(text_));
    progress.update(this->progress());
  }
  file_.clear();
  file_.seekg(0);
  read_bytes_ = 0.0;
}

// A line that is too long may be a hole.
bool TextReader::next_line() {
  if (!files::read_line(file_, text_)) return false;
  read_bytes_ += static_cast<double>(text_.size()) + 1.0;
  if (text_.size() < kLongestLine) return true;
  const int64_t at = file_.tellg();
  const int64_t data = ros::ByteFile(path_).next_data(at);
  if (data > at) file_.seekg(data);
  read_bytes_ = static_cast<double>(data);
  return true;
}

bool TextReader::read_piece() {
  if (!next_line()) return false;
  ++line_number_;
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
