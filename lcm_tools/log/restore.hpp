#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "lcm_tools/base/utime.hpp"
#include "lcm_tools/files/event_log.hpp"

/// Reconstructs damaged headers from the undamaged parts of a log. No file access.
namespace marco::logs {

/// The channels of a log and the types on them, as learned from its whole events.
class KnownChannels {
 public:
  void add(std::string_view channel, uint64_t fingerprint, int64_t data_bytes);

  /// Events seen on it.
  int64_t events(std::string_view channel) const;

  /// The size that all its messages have, but for a quarter at most; nothing when there is none.
  std::optional<int64_t> usual_data_bytes(std::string_view channel) const;

  /// The only channel of at least 5 events that differs from `damaged` in one byte and carries
  /// `fingerprint`; nothing when there is none or there are several.
  std::optional<std::string> nearest(std::string_view damaged, uint64_t fingerprint) const;

  /// The channel's usual fingerprint, when `damaged` differs from it in one byte, was met on the
  /// channel once only, and the usual one at least 5 times.
  std::optional<uint64_t> mend_fingerprint(std::string_view channel, uint64_t damaged) const;

 private:
  struct Types {
    int64_t events = 0;
    std::map<uint64_t, int64_t> counts;
    int64_t majority_bytes = -1;  // of the majority vote (Boyer and Moore)
    int64_t majority_votes = 0;
  };
  std::map<std::string, Types, std::less<>> channels_;
};

/// The four numbers of a header and whether its sync word stands, perhaps with one byte damaged.
struct HeaderBytes {
  explicit HeaderBytes(const uint8_t* bytes);  ///< 28 of them

  bool sync_like = false;  ///< at least 3 of 4 bytes
  int64_t number = 0;
  Utime event_time;
  uint32_t channel_bytes = 0;
  uint32_t data_bytes = 0;
};

/// How a header fills the bytes up to the next event.
struct Layout {
  uint32_t channel_bytes = 0;
  uint32_t data_bytes = 0;
  std::string channel;
  const char* mended = "";  ///< what was damaged
};

/// Reads an event whose header is damaged in one field: sync word, one of the lengths, or one byte
/// of the channel.
/// @param following the bytes behind the header, at least 63 + 8 where the event is that long
/// @param body_bytes channel and data together, known from where the next event begins
std::optional<Layout> lay_out(const HeaderBytes& header,
                              std::string_view following,
                              int64_t body_bytes,
                              const KnownChannels& known);

uint64_t read_fingerprint(std::string_view data);

}  // namespace marco::logs
