#include "recordings/sample_reader.hpp"

#include <array>
#include <cstdarg>
#include <cstdio>

namespace marco::files {

std::optional<Sample> QueuedReader::next() {
  while (queue_.empty() && !ended_) {
    if (read_piece()) continue;
    ended_ = true;
    finish_report();
  }
  if (queue_.empty()) return std::nullopt;
  Sample sample = std::move(queue_.front());
  queue_.pop_front();
  return sample;
}

void QueuedReader::queue_odometry(Utime utime, const Pose2& odom_from_robot) {
  OdometrySample sample;
  sample.utime = utime;
  sample.odom_from_robot = odom_from_robot;
  queue(sample);
}

void QueuedReader::note(const char* format, ...) {
  std::array<char, 300> text{};
  va_list values;
  va_start(values, format);
  std::vsnprintf(text.data(), text.size(), format, values);
  va_end(values);
  report_.notes.emplace_back(text.data());
}

}  // namespace marco::files
