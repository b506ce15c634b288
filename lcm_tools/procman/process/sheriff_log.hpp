#pragma once

#include <deque>
#include <functional>
#include <string>

#include "lcm_tools/procman/output_log.hpp"
#include "procman_lcm/output_span_t.hpp"
#include "procman_lcm/output_t.hpp"

namespace marco::procman {

/// What a sheriff shows its user: events, and the commands' output.
class SheriffLog {
 public:
  /// Appends an event, with the time of day.
  void note(const std::string& event);
  /// Notes the last lines of a command's output.
  void note_last_output(const std::string& id);

  void on_span(const procman_lcm::output_span_t& message);
  /// Lines of a deputy's own (id "") become events.
  void on_output(const procman_lcm::output_t& message);

  const std::deque<std::string>& events() const { return events_; }
  const std::deque<std::string>& output(const std::string& id) const { return output_.lines(id); }

  /// Called with each event, and with each whole line of a command's output.
  std::function<void(const std::string& line)> on_event;
  std::function<void(const std::string& id, const std::string& line)> on_output_line;

 private:
  std::deque<std::string> events_;
  OutputLog output_;
};

}  // namespace marco::procman
