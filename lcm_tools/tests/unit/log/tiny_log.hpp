#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/tests/support/encoded.hpp"
#include "robot/pose2_t.hpp"

namespace marco::logs {

/// A folder of its own for a test.
class ScratchFolder {
 public:
  ScratchFolder() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("marco_log_test_" + std::to_string(getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

inline constexpr int64_t kStartUs = 1'454'600'000'000'000;  // 2016-02-04T15:33:20Z

inline std::vector<uint8_t> pose_bytes(int64_t utime_us, double x_m) {
  robot::pose2_t pose{};
  pose.utime = utime_us;
  pose.x_m = x_m;
  return testing::encoded(pose);
}

/// `count` poses each 100 ms, on TRUE_POSE and OTHER in turn; their x counts the events.
inline void write_poses(const std::string& path, int count, int64_t start_us = kStartUs) {
  files::EventLogWriter writer(path);
  for (int i = 0; i < count; ++i) {
    const int64_t us = start_us + int64_t{100'000} * i;
    writer.write(i % 2 == 0 ? "TRUE_POSE" : "OTHER", pose_bytes(us, i), Utime::from_us(us));
  }
  writer.flush();
}

inline std::vector<files::LogEvent> read_events(const std::string& path) {
  files::EventLogReader reader(path);
  std::vector<files::LogEvent> events;
  while (auto event = reader.next()) events.push_back(std::move(*event));
  return events;
}

inline std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_text(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline void ignore_progress(double /*part*/) {}

}  // namespace marco::logs
