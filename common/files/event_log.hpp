#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/utime.hpp"

namespace marco::files {

/// One event of an LCM log file.
struct LogEvent {
  int64_t number = 0;
  Utime event_time;  ///< when the logger had it
  std::string channel;
  std::vector<uint8_t> bytes;
};

/// What a reader met that was no whole event.
struct LogDamage {
  int64_t places = 0;         ///< how often it had to look for the next event
  int64_t bytes_skipped = 0;  ///< not part of any event
  int64_t first_offset = -1;  ///< [byte] of the first damage, -1 = none
};

/// Reads LCM event logs (28-byte header: sync 0xEDA1DA01, number, time, two lengths; big endian).
/// Unlike liblcm 1.3.1, whose reader ends at the first damaged event, it goes on at the next event
/// that is whole: a sync word, lengths within bounds, a printable channel, and then either the next
/// sync word or the end, or at least no other event's head inside it. Constant memory. Not
/// thread-safe.
class EventLogReader {
 public:
  /// @throws std::invalid_argument naming the path when it cannot be read.
  explicit EventLogReader(const std::string& path);

  /// The next whole event; nothing at the end.
  std::optional<LogEvent> next();

  const LogDamage& damage() const { return damage_; }
  int64_t size_bytes() const { return size_; }
  int64_t position_bytes() const { return position_; }

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  bool read_at(int64_t offset, std::span<uint8_t> bytes);
  std::optional<LogEvent> read_event_at(int64_t offset);
  bool followed_by_event(int64_t end);
  bool contains_head(int64_t from, int64_t end);
  std::optional<int64_t> find_sync(int64_t from);

  std::unique_ptr<std::FILE, Closer> file_;
  std::string path_;
  int64_t size_ = 0;
  int64_t position_ = 0;
  int64_t file_offset_ = 0;
  LogDamage damage_;
};

/// Writes LCM event logs that lcm-logplayer plays.
class EventLogWriter {
 public:
  /// @throws std::runtime_error naming the path when it cannot be created.
  explicit EventLogWriter(const std::string& path);

  /// @throws std::runtime_error naming the path when the disk is full.
  void write(const std::string& channel, std::span<const uint8_t> bytes, Utime event_time);

  /// Flushes and reports what only a flush tells. @throws std::runtime_error as write.
  void flush();

  int64_t events_written() const { return next_number_; }

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Closer> file_;
  std::string path_;
  int64_t next_number_ = 0;
};

}  // namespace marco::files
