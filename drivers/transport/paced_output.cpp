#include "drivers/transport/paced_output.hpp"

#include <algorithm>

#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers {
namespace {

constexpr Duration kChunk = Duration::from_us(2000);

}  // namespace

Utime PacedOutput::Telegram::end_of(std::size_t count) const {
  return start + line_time(count, baud);
}

void PacedOutput::send(std::span<const uint8_t> bytes, Utime earliest) {
  if (bytes.empty()) return;
  queue_.push_back({{bytes.begin(), bytes.end()}, std::max(earliest, free_at_), baud_});
  free_at_ = queue_.back().end_of(bytes.size());
}

void PacedOutput::advance(Utime now, std::vector<uint8_t>& out) {
  last_advance_ = now;
  while (!queue_.empty()) {
    Telegram& first = queue_.front();
    std::size_t due = first.sent;
    if (now >= first.end_of(first.bytes.size())) {
      due = first.bytes.size();
    } else if (now > first.start) {
      due = static_cast<std::size_t>((now - first.start).us * first.baud / 10'000'000);
    }
    if (due > first.sent) {
      out.insert(out.end(), first.bytes.begin() + static_cast<std::ptrdiff_t>(first.sent),
                 first.bytes.begin() + static_cast<std::ptrdiff_t>(due));
      first.sent = due;
    }
    if (due < first.bytes.size()) return;
    queue_.pop_front();
  }
}

Utime PacedOutput::next_event() const {
  if (queue_.empty()) return kFarFuture;
  const Telegram& first = queue_.front();
  const Utime end = first.end_of(first.bytes.size());
  return std::min(end, std::max(first.start, last_advance_) + kChunk);
}

void PacedOutput::clear() {
  queue_.clear();
  free_at_ = {};
}

}  // namespace marco::drivers
