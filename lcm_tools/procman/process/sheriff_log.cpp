#include "lcm_tools/procman/process/sheriff_log.hpp"

#include <ctime>
#include <utility>

namespace marco::procman {
namespace {

constexpr std::size_t kMaxEvents = 5000;
constexpr std::size_t kMaxEventBytes = 1000;
constexpr std::size_t kLastLines = 5, kLastLineBytes = 200;

std::string time_of_day() {
  const std::time_t now = std::time(nullptr);
  std::tm local = {};
  localtime_r(&now, &local);
  char text[16];
  std::strftime(text, sizeof text, "%H:%M:%S", &local);
  return text;
}

}  // namespace

void SheriffLog::note(const std::string& event) {
  events_.push_back(time_of_day() + " " + event.substr(0, kMaxEventBytes));
  if (events_.size() > kMaxEvents) events_.pop_front();
  if (on_event) on_event(events_.back());
}

void SheriffLog::note_last_output(const std::string& id) {
  std::deque<std::string> last;
  const std::deque<std::string>& lines = output(id);
  for (auto line = lines.rbegin(); line != lines.rend() && last.size() < kLastLines; ++line) {
    if (!line->empty()) last.push_front(printable(*line).substr(0, kLastLineBytes));
  }
  if (last.empty()) note("  " + id + " has written nothing yet");
  const std::string head = "  " + id + "| ";
  for (const std::string& line : last) note(head + line);
}

void SheriffLog::on_span(const procman_lcm::output_span_t& message) {
  std::vector<OutputSpan> spans;
  for (std::size_t i = 0; i < message.command_ids.size(); ++i) {
    spans.push_back(
        {message.command_ids[i], message.first_bytes[i], message.end_bytes[i], message.files[i]});
  }
  output_.on_span(message.deputy_id, message.utime, std::move(spans));
}

void SheriffLog::on_output(const procman_lcm::output_t& message) {
  for (const auto& [id, line] :
       output_.on_output(message.deputy_id, message.utime, message.command_ids, message.text)) {
    if (id.empty()) note(message.deputy_id + ": " + line);
    if (!id.empty() && on_output_line) on_output_line(id, line);
  }
}

}  // namespace marco::procman
