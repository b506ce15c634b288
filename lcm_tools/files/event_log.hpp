#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lcm_tools/base/utime.hpp"
#include "lcm_tools/files/output_file.hpp"

namespace marco::files {

/// One event of an LCM log file.
struct LogEvent {
  int64_t number = 0;
  Utime event_time;  ///< when the logger received it
  std::string channel;
  std::vector<uint8_t> bytes;
};

/// Bytes that belong to no whole event.
struct LogDamage {
  int64_t places = 0;         ///< how often the reader searched for the next event
  int64_t bytes_skipped = 0;  ///< not part of any event
  int64_t first_offset = -1;  ///< [byte] of the first damage, -1 = none
};

/// An event without its data, for callers that inspect headers or copy bytes. The views are valid
/// until the reader's next call.
struct LogEventHead {
  int64_t offset = 0;  ///< [byte] of its header in the file
  int64_t number = 0;
  Utime event_time;
  std::string_view channel;
  int64_t data_bytes = 0;
  std::span<const uint8_t> first_bytes;  ///< of the data: at most kFirstBytes
  int64_t skipped_bytes = 0;             ///< damage directly before this event

  static constexpr std::size_t kFirstBytes = 16;  ///< fingerprint and utime
  int64_t data_offset() const { return offset + 28 + static_cast<int64_t>(channel.size()); }
  int64_t end_offset() const { return data_offset() + data_bytes; }
};

/// Reads LCM event logs (28-byte header: sync 0xEDA1DA01, number, time, two lengths; big endian).
/// liblcm 1.3.1 stops at the first damaged event; this reader continues with the next whole one. An
/// event is whole if it has a sync word, lengths within bounds and a printable channel, and if it
/// is followed by a sync word or the end of the file, or at least contains no other event's header.
/// Memory: a window of 256 kB or the largest event. Not thread-safe.
class EventLogReader {
 public:
  /// @throws std::invalid_argument naming the path when it cannot be read.
  explicit EventLogReader(const std::string& path);

  /// The next whole event; nothing at the end.
  std::optional<LogEvent> next();

  /// The next whole event without its data, which is not even read for large events.
  std::optional<LogEventHead> next_head();

  /// The data of the event that next_head returned last; valid until the next call. Empty also when
  /// the file has shrunk.
  std::span<const uint8_t> data();

  /// Continues with the first whole event at or after `offset`. Skipped bytes are not damage.
  void seek(int64_t offset);

  /// Called with the place reached, again and again while whole events are searched behind damage.
  void on_search(std::function<void(int64_t)> on_search) { on_search_ = std::move(on_search); }

  /// Raw bytes of the file. @returns whether all of them could be read
  bool read_at(int64_t offset, std::span<uint8_t> bytes) const;

  const LogDamage& damage() const { return damage_; }
  int64_t size_bytes() const { return size_; }
  int64_t position_bytes() const { return position_; }

 private:
  class Descriptor {
   public:
    explicit Descriptor(const std::string& path);
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int get() const { return descriptor_; }

   private:
    int descriptor_;
  };
  const uint8_t* view(int64_t offset, int64_t count);
  bool read_head_at(int64_t offset);
  bool followed_by_event(int64_t end);
  bool contains_head(int64_t from, int64_t end);
  std::optional<int64_t> find_sync(int64_t from, int64_t end);
  std::optional<int64_t> find_whole_event(int64_t from);

  Descriptor file_;
  int64_t size_ = 0;
  int64_t position_ = 0;
  std::vector<uint8_t> window_;
  int64_t window_start_ = 0;
  int64_t window_bytes_ = 0;
  int64_t step_bytes_ = 64 << 10;  // of the next reading, at least
  LogEventHead head_;
  std::string channel_;
  std::array<uint8_t, LogEventHead::kFirstBytes> first_bytes_{};
  LogDamage damage_;
  std::function<void(int64_t)> on_search_;
};

/// The 28 bytes before an event's channel. @throws std::invalid_argument when the channel is empty
/// or longer than 63 bytes.
std::array<uint8_t, 28> event_header(int64_t number,
                                     Utime event_time,
                                     std::string_view channel,
                                     std::size_t data_bytes);

/// Writes LCM event logs that lcm-logplayer plays.
class EventLogWriter {
 public:
  /// A recording: visible under its name from the first event, so that a crash loses little.
  /// @throws std::runtime_error naming the path when it cannot be created.
  explicit EventLogWriter(const std::string& path);
  /// A result: the log appears under its name with out.finish(). `out` outlives the writer.
  explicit EventLogWriter(OutputFile& out) : out_(&out) {}

  /// @throws std::runtime_error naming the path when the disk is full.
  void write(std::string_view channel, std::span<const uint8_t> bytes, Utime event_time);

  /// Flushes, and reports errors that only a flush reveals. @throws std::runtime_error as write.
  void flush() { out_->flush(); }

  int64_t events_written() const { return next_number_; }

 private:
  std::unique_ptr<OutputFile> own_;
  OutputFile* out_;
  int64_t next_number_ = 0;
};

}  // namespace marco::files
