#include "procman/output_log.hpp"

#include <utility>

namespace marco::procman {
namespace {

// Binary output has no lines.
constexpr std::size_t kMaxLineBytes = std::size_t{64} * 1024;

}  // namespace

void OutputLog::on_span(const std::string& deputy,
                        int64_t utime_us,
                        std::vector<OutputSpan> spans) {
  announced_[deputy] = {utime_us, std::move(spans)};
}

std::vector<std::pair<std::string, std::string>> OutputLog::on_output(
    const std::string& deputy,
    int64_t utime_us,
    const std::vector<std::string>& ids,
    const std::vector<std::string>& texts) {
  std::vector<std::pair<std::string, std::string>> completed;
  const auto announced = announced_.find(deputy);
  const bool matches = announced != announced_.end() && announced->second.utime_us == utime_us &&
                       announced->second.spans.size() == ids.size();
  for (std::size_t i = 0; i < ids.size() && i < texts.size(); ++i) {
    Buffer& buffer = buffers_[ids[i]];
    if (!matches) {
      buffer.expected_byte.reset();
    } else if (const OutputSpan& span = announced->second.spans[i]; span.first_byte >= 0) {
      if (buffer.file == span.file && buffer.expected_byte &&
          span.first_byte > *buffer.expected_byte) {
        const int64_t lost = span.first_byte - *buffer.expected_byte;
        lost_bytes_ += lost;
        append(ids[i],
               "\n[" + std::to_string(lost) + " bytes lost on the way; all is in " + span.file +
                   " of " + deputy + "]\n",
               completed);
      }
      buffer.expected_byte = span.end_byte;
      buffer.file = span.file;
    }
    append(ids[i], texts[i], completed);
  }
  return completed;
}

void OutputLog::append(const std::string& id,
                       const std::string& text,
                       std::vector<std::pair<std::string, std::string>>& completed) {
  std::deque<std::string>& lines = buffers_[id].lines;
  if (lines.empty()) lines.emplace_back();
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    lines.back().append(text, begin, end - begin);
    if (!lines.back().empty() && lines.back().back() == '\r') lines.back().pop_back();
    completed.emplace_back(id, lines.back());
    lines.emplace_back();
    if (lines.size() > max_lines_) lines.pop_front();
  }
  lines.back().append(text, begin);
  if (lines.back().size() > kMaxLineBytes) lines.emplace_back();
}

const std::deque<std::string>& OutputLog::lines(const std::string& id) const {
  static const std::deque<std::string> nothing;
  const auto at = buffers_.find(id);
  return at != buffers_.end() ? at->second.lines : nothing;
}

std::string printable(const std::string& line) {
  std::string out;
  for (std::size_t at = 0; at < line.size(); ++at) {
    const auto c = static_cast<unsigned char>(line[at]);
    if (c == 0x1b) {
      const bool sequence = at + 1 < line.size() && line[at + 1] == '[';
      at += sequence ? 2 : 1;
      while (sequence && at < line.size() && (line[at] < 0x40 || line[at] > 0x7e)) ++at;
    } else if (c == '\t') {
      out += "  ";
    } else if (c == '\r') {
      out.clear();  // a progress line shows its last state
    } else if (c >= 0x20 && c != 0x7f) {
      out += line[at];
    }
  }
  return out;
}

}  // namespace marco::procman
