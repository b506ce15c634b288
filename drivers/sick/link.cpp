#include "drivers/sick/link.hpp"

#include <stdexcept>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::drivers::sick {
namespace {

constexpr Duration kByteGap = Duration::from_us(100'000);  // the device's promise: 14 ms
constexpr int kFastBaud = 500'000;  // from here on the laser needs 55 us between our bytes
constexpr int kMaxFailures = 2;
constexpr int kSafeBaud = 9600;

}  // namespace

SickLink::SickLink(ByteStream& stream, int wanted_baud, Clock clock)
    : stream_(stream),
      clock_(std::move(clock)),
      search_(wanted_baud, {9600, 38400, 500'000, 19200}),
      goal_baud_(wanted_baud) {}

std::string SickLink::try_next_baud_rate() {
  try {
    set_baud(search_.next());
    return {};
  } catch (const std::invalid_argument& cannot) {
    require(search_.drop_current(), "this port supports none of the laser's baud rates");
    goal_baud_ = search_.next();
    set_baud(goal_baud_);
    return cannot.what();
  }
}

void SickLink::use_goal_baud() { set_baud(goal_baud_); }

bool SickLink::fall_back() {
  if (++failures_ < kMaxFailures) return false;
  goal_baud_ = kSafeBaud;
  return true;
}

void SickLink::set_baud(int baud) {
  baud_ = baud;
  stream_.set_line({baud, Parity::none});
  stream_.discard_input();
  parser_.clear();
}

void SickLink::send(const Bytes& telegram) {
  if (baud_ < kFastBaud) return stream_.write(telegram);
  for (const uint8_t& byte : telegram) {
    stream_.write({&byte, 1});
    uint8_t early[64];
    parser_.push({early, stream_.read(early, std::chrono::microseconds(100))});
  }
}

SickLink::Received SickLink::receive(std::chrono::microseconds timeout) {
  uint8_t buffer[4096];
  const std::size_t count = stream_.read(buffer, timeout);
  Received received{clock_(), false};
  if (count > 0) {
    last_byte_ = received.arrival;
    parser_.push({buffer, count});
  } else if (parser_.waiting() && received.arrival - last_byte_ >= kByteGap) {
    parser_.give_up_waiting();
    received.gap = true;
  }
  return received;
}

}  // namespace marco::drivers::sick
