#include "lcm_tools/log/event_sequence.hpp"

#include <algorithm>

#include "lcm_tools/log/moment.hpp"

namespace marco::logs {

std::optional<int64_t> EventSequence::repaired_number(int64_t number,
                                                      const EventPlace* next) const {
  constexpr int64_t kFar = 1 << 24;
  const int64_t last = last_.number;
  if (next == nullptr) {
    const bool fits = events_ == 0 || (number > last && number - kFar < last);
    return fits ? std::nullopt : std::optional(last + 1);
  }
  if (events_ == 0) {
    const bool fits =
        number < next->number && (number >= 0 || next->number < 0) && next->number - number < kFar;
    return fits || next->number <= 0 ? std::nullopt : std::optional(next->number - 1);
  }
  const bool fits = number > last && number < next->number;
  const bool room = last + 1 < next->number && next->number - last < kFar;
  return fits || !room ? std::nullopt : std::optional(last + 1);
}

std::optional<Utime> EventSequence::repaired_time(Utime time, const EventPlace* next) const {
  if (events_ == 0 && next == nullptr) return std::nullopt;
  const Utime before = events_ > 0 ? last_.time : next->time;
  return logs::repaired_time(time, before, next != nullptr ? next->time : before);
}

void EventSequence::add(const EventPlace& written) {
  if (events_++ == 0) first_number_ = written.number;
  last_ = written;
}

int64_t EventSequence::missing_numbers() const {
  int64_t span = 0;
  if (__builtin_sub_overflow(last_.number, first_number_, &span)) return 0;
  return std::max<int64_t>(0, span - events_ + 1);
}

std::optional<Utime> repaired_time(Utime time, Utime before, Utime after) {
  constexpr int64_t kTogetherUs = 60000000;
  constexpr int64_t kToleranceUs = 2000000;
  const auto [low, high] = std::minmax({bounded(before).us, bounded(after).us});
  const int64_t us = bounded(time).us;
  if (high - low > kTogetherUs) return std::nullopt;
  if (us >= low - kToleranceUs && us <= high + kToleranceUs) return std::nullopt;
  const auto value = static_cast<uint64_t>(time.us);
  for (const int64_t neighbour : {low, high}) {
    for (unsigned shift = 0; shift < 64; shift += 8) {
      const uint64_t mask = uint64_t{0xFF} << shift;
      const auto repaired =
          static_cast<int64_t>((value & ~mask) | (static_cast<uint64_t>(neighbour) & mask));
      if (repaired >= low && repaired <= high) return Utime::from_us(repaired);
    }
  }
  return Utime::from_us(low + (high - low) / 2);
}

}  // namespace marco::logs
