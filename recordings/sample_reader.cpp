#include "recordings/sample_reader.hpp"

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace marco::files {

std::optional<Sample> QueuedReader::next() {
  while (queue_.empty() && !ended_) {
    if (read_piece()) continue;
    ended_ = true;
    finish_report();
    note_stamps();
  }
  if (queue_.empty()) return std::nullopt;
  Sample sample = std::move(queue_.front());
  queue_.pop_front();
  return sample;
}

void QueuedReader::queue(Sample sample) {
  if (const auto* scan = std::get_if<LaserScan>(&sample)) watch_stamps(*scan);
  queue_.push_back(std::move(sample));
}

void QueuedReader::watch_stamps(const LaserScan& scan) {
  constexpr double kFarS = 3600.0;
  const auto [last, is_first] = last_stamp_.try_emplace(scan.channel, scan.utime);
  const double step_s = (scan.utime - last->second).seconds();
  ++scans_;
  equal_stamps_ += !is_first && step_s == 0.0 ? 1 : 0;
  far_stamps_ += std::abs(step_s) > kFarS ? 1 : 0;
  last->second = scan.utime;
}

// A map may be right all the same; the times of its path say nothing.
void QueuedReader::note_stamps() {
  const auto note_if = [this](int64_t count, const char* what) {
    if (2 * count <= scans_) return;
    note("%lld of %lld scans %s: their stamps are not measurement times",
         static_cast<long long>(count), static_cast<long long>(scans_), what);
  };
  note_if(equal_stamps_, "have the stamp of the previous one");
  note_if(far_stamps_, "are an hour or more from the previous one");
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
