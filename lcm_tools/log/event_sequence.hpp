#pragma once

#include <cstdint>
#include <optional>

#include "lcm_tools/base/utime.hpp"

namespace marco::logs {

/// The place of an event in a log.
struct EventPlace {
  int64_t number = 0;
  Utime time;
};

/// The numbers and times of the events that a repair has written so far. They tell whether those of
/// the next event are damaged.
class EventSequence {
 public:
  /// @param next  the event behind this one; null at the end of the log
  /// @returns the number to write instead; nothing when this one is plausible or cannot be
  /// restored. Numbers grow: one that does not, or that is far from its neighbours, is damaged.
  std::optional<int64_t> repaired_number(int64_t number, const EventPlace* next) const;
  /// The same of the time, by repaired_time.
  std::optional<Utime> repaired_time(Utime time, const EventPlace* next) const;

  void add(const EventPlace& written);
  /// Numbers between the first and the last that no event has.
  int64_t missing_numbers() const;

 private:
  int64_t events_ = 0;
  int64_t first_number_ = 0;
  EventPlace last_{-1, {}};
};

/// For a time more than 2 s outside of its neighbours, which are themselves within a minute: the
/// time with one byte taken from a neighbour, if that puts it between them, else the middle between
/// them. Nothing when the time is plausible.
std::optional<Utime> repaired_time(Utime time, Utime before, Utime after);

}  // namespace marco::logs
