#include "lcm_tools/procman/output_log.hpp"

#include <algorithm>
#include <utility>

#include "lcm_tools/base/printable.hpp"

namespace marco::procman {
namespace {

// Anybody on the network can make up deputies and commands.
constexpr std::size_t kMostBuffers = 10000, kMostAnnounced = 1000, kMaxIdBytes = 1000;
constexpr std::size_t kBytesPerLine = sizeof(std::string);

}  // namespace

void OutputLog::on_span(const std::string& deputy,
                        int64_t utime_us,
                        std::vector<OutputSpan> spans) {
  // One that waits for its text is enough: it comes right after.
  if (announced_.size() >= kMostAnnounced && !announced_.contains(deputy)) announced_.clear();
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
    const bool is_known = buffers_.contains(ids[i]);
    if (!is_known && (buffers_.size() >= kMostBuffers || ids[i].size() > kMaxIdBytes)) continue;
    Buffer& buffer = buffers_[ids[i]];
    if (!matches) {
      buffer.expected_byte.reset();
    } else if (const OutputSpan& span = announced->second.spans[i]; span.first_byte >= 0) {
      if (buffer.file == span.file && buffer.expected_byte &&
          span.first_byte > *buffer.expected_byte) {
        const int64_t lost = span.first_byte - *buffer.expected_byte;
        lost_bytes_ += lost;
        append(ids[i],
               "\n[" + std::to_string(lost) + " bytes lost in transit; all output is in " +
                   span.file + " of " + deputy + "]\n",
               completed);
      }
      buffer.expected_byte = span.end_byte;
      buffer.file = span.file;
    }
    append(ids[i], texts[i], completed);
  }
  if (announced != announced_.end()) announced_.erase(announced);
  return completed;
}

void OutputLog::append(const std::string& id, std::string_view text, Completed& completed) {
  Buffer& buffer = buffers_[id];
  if (buffer.lines.empty()) buffer.lines.emplace_back();
  while (!text.empty()) {
    // Binary output has no lines.
    const std::size_t room = kMaxLineBytes - std::min(kMaxLineBytes, buffer.lines.back().size());
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view piece = text.substr(0, std::min(end, room));
    buffer.lines.back() += piece;
    buffer.bytes += piece.size();
    bytes_ += piece.size();
    text.remove_prefix(piece.size());
    if (text.empty()) break;
    if (text.front() == '\n') text.remove_prefix(1);
    end_line(id, buffer, completed);
  }
  while (bytes_ > kMaxBytes) drop_of_longest();
}

void OutputLog::end_line(const std::string& id, Buffer& buffer, Completed& completed) {
  std::string& line = buffer.lines.back();
  if (!line.empty() && line.back() == '\r') {
    line.pop_back();
    --buffer.bytes;
    --bytes_;
  }
  completed.emplace_back(id, line);
  buffer.lines.emplace_back();
  buffer.bytes += kBytesPerLine;
  bytes_ += kBytesPerLine;
  while (buffer.lines.size() > max_lines_ || buffer.bytes > kMaxCommandBytes) drop_oldest(buffer);
}

void OutputLog::drop_oldest(Buffer& buffer) {
  const std::size_t size = buffer.lines.front().size() + kBytesPerLine;
  buffer.lines.pop_front();
  buffer.bytes -= size;
  bytes_ -= size;
}

void OutputLog::drop_of_longest() {
  const auto longest = std::max_element(
      buffers_.begin(), buffers_.end(),
      [](const auto& a, const auto& b) { return a.second.bytes < b.second.bytes; });
  Buffer& buffer = longest->second;
  const std::size_t wanted = buffer.bytes / 2;
  while (buffer.lines.size() > 1 && buffer.bytes > wanted) drop_oldest(buffer);
  if (buffer.lines.size() > 1) return;
  bytes_ -= buffer.bytes;
  buffer.lines.clear();
  buffer.bytes = 0;
}

const std::deque<std::string>& OutputLog::lines(const std::string& id) const {
  static const std::deque<std::string> kNothing;
  const auto at = buffers_.find(id);
  return at != buffers_.end() ? at->second.lines : kNothing;
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
  return marco::printable(out);
}

}  // namespace marco::procman
