#include "drivers/sick/driver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::sick {
namespace {

using std::chrono::microseconds;
constexpr microseconds kStep{50'000};
constexpr Duration kSettle = Duration::from_us(250'000);
constexpr Duration kByteGap = Duration::from_us(100'000);  // the device's promise: 14 ms
constexpr Duration kNakRest = Duration::from_us(30'000);   // before the request is sent again
constexpr Duration kDamagedRest = Duration::from_us(250'000);
constexpr Duration kStopPatience = Duration::from_us(500'000);
constexpr int kTries = 3;
constexpr int kFastBaud = 500'000;  // from here on the laser needs 55 us between our bytes

int measuring_mode_for(const std::string& unit, int range_m) {
  require(unit == "mm" || unit == "cm", "SICK unit is 'mm' or 'cm', not '" + unit + "'");
  const int scaled_m = unit == "mm" ? range_m : range_m / 10;
  require(scaled_m == 8 || scaled_m == 16 || scaled_m == 32,
          "SICK range_m is 8, 16 or 32 in mm, 80, 160 or 320 in cm; not " +
              std::to_string(range_m) + " in " + unit);
  return scaled_m == 8 ? 0x00 : scaled_m == 16 ? 0x04 : 0x06;
}

std::vector<int> rates_to_try(int wanted) {
  std::vector<int> rates{wanted};
  for (const int rate : {9600, 38400, 500'000, 19200}) {
    if (rate != wanted) rates.push_back(rate);
  }
  return rates;
}

}  // namespace

SickDriver::SickDriver(ByteStream& stream, const SickOptions& options, Clock clock)
    : stream_(stream),
      options_(options),
      clock_(std::move(clock)),
      rates_(rates_to_try(options.baud)),
      goal_baud_(options.baud),
      measuring_mode_(measuring_mode_for(options.unit, options.range_m)),
      unit_(options.unit == "mm" ? Unit::mm : Unit::cm),
      turns_(1.0) {
  validate(options, "sick");
  require(mode_of_baud(options.baud).has_value(),
          "SICK baud is 9600, 19200, 38400 or 500000; not " + std::to_string(options.baud));
  require(beams_of_variant(options.angle_deg, resolution_cdeg()) > 0,
          "the laser has no variant of " + std::to_string(options.angle_deg) + " deg by " +
              std::to_string(options.resolution_deg) +
              " deg: there are 180 by 1 or 0.5 deg, and 100 by 1, 0.5 or 0.25 deg");
  require(options.password.size() == 8, "the laser's password has 8 characters");
  turns_ = TurnCounter(scan_period_s());
  look_elsewhere();
}

// ---- asking ------------------------------------------------------------------------------------

void SickDriver::enter(Phase phase) {
  phase_ = phase;
  tries_ = 0;
  if (phase == Phase::measuring) {
    turns_.reset();
    filter_.reset();
    trouble_.clear();
    last_scan_ = clock_();
    return;
  }
  if (phase == Phase::settling) {
    set_baud(goal_baud_);
    settled_at_ = clock_() + kSettle;
    return;
  }
  ask();
}

void SickDriver::ask() {
  ++tries_;
  send(request_of(phase_));
  deadline_ = clock_() + patience_of(phase_);
}

void SickDriver::send(const Bytes& telegram) {
  if (baud_ < kFastBaud) return stream_.write(telegram);
  for (const uint8_t& byte : telegram) {
    stream_.write({&byte, 1});
    uint8_t early[64];
    parser_.push({early, stream_.read(early, microseconds(100))});
  }
}

// A reply was lost: the laser, which may have seven seconds for some, is not waited for so long.
void SickDriver::ask_again_within(Duration rest) {
  deadline_ = std::min(deadline_, clock_() + rest);
}

void SickDriver::set_baud(int baud) {
  baud_ = baud;
  stream_.set_line({baud, Parity::none});
  stream_.discard_input();
  parser_.clear();
}

void SickDriver::look_elsewhere() {
  if (baud_ != 0) rate_ = (rate_ + 1) % rates_.size();
  try {
    set_baud(rates_[rate_]);
  } catch (const std::invalid_argument& cannot) {
    trouble_ = cannot.what();
    rates_.erase(rates_.begin() + static_cast<std::ptrdiff_t>(rate_));
    rate_ = 0;
    require(!rates_.empty(), "this port can do none of the laser's baud rates");
    set_baud(rates_[rate_]);
    goal_baud_ = rates_[0];
  }
  streams_here_ = acknowledged_ = false;
  enter(Phase::finding);
}

void SickDriver::start_over(const std::string& why) {
  trouble_ = why;
  rate_ = rates_.size() - 1;
  look_elsewhere();
}

// ---- hearing -----------------------------------------------------------------------------------

std::vector<ArrivedScan> SickDriver::step() {
  receive();
  if (phase_ == Phase::settling) {
    if (clock_() >= settled_at_) enter(Phase::checking_baud);
  } else if (phase_ == Phase::measuring) {
    const double line_s = line_time(2 * 401 + 12, baud_).seconds();
    if ((clock_() - last_scan_).seconds() > 0.3 + 3.0 * std::max(scan_period_s(), line_s)) {
      start_over("no scans came any more");
    }
  } else if (clock_() >= deadline_) {
    on_timeout();
  }
  counts_.garbage_bytes = parser_.garbage_bytes();
  return std::exchange(ready_, {});
}

void SickDriver::on_line_emptied() {
  parser_.clear();
  turns_.reset();
  filter_.reset();
  last_scan_ = clock_();
}

void SickDriver::receive() {
  microseconds wait = kStep;
  if (phase_ != Phase::measuring) {
    const Utime until = phase_ == Phase::settling ? settled_at_ : deadline_;
    wait = std::clamp(microseconds((until - clock_()).us), microseconds(0), kStep);
  }
  if (parser_.waiting()) wait = std::min(wait, microseconds(kByteGap.us));
  uint8_t buffer[4096];
  const std::size_t count = stream_.read(buffer, wait);
  const Utime arrival = clock_();
  if (count > 0) {
    last_byte_ = arrival;
    parser_.push({buffer, count});
  } else if (parser_.waiting() && arrival - last_byte_ >= kByteGap) {
    parser_.give_up_waiting();
    ask_again_within(kDamagedRest);
  }
  while (const auto event = parser_.next()) on_event(*event, arrival);
}

void SickDriver::on_event(const Event& event, Utime arrival) {
  if (event.kind == Event::Kind::bad_checksum) {
    if (phase_ == Phase::measuring) ++counts_.drops["bad_checksum"];
    return ask_again_within(kDamagedRest);
  }
  if (event.kind == Event::Kind::ack) {
    // Heard at this speed: a change of mode may take the laser three seconds.
    if (phase_ == Phase::finding && parser_.garbage_bytes() == counts_.garbage_bytes) {
      acknowledged_ = true;
      deadline_ = std::max(deadline_, clock_() + kModePatience);
    }
    return;
  }
  if (event.kind == Event::Kind::nak) return ask_again_within(kNakRest);
  status_ = event.status();
  if (event.code() == kPowerOnReply) {
    const std::span<const uint8_t> text = event.data();
    type_.assign(text.begin(), text.end());
    if (phase_ == Phase::finding) return ask();
    start_over("the laser was reset");
  } else if (event.code() == kValuesReply && phase_ == Phase::measuring) {
    on_values(event, arrival - line_time(event.bytes_after, baud_));
  } else if (phase_ != Phase::measuring && phase_ != Phase::settling) {
    on_reply(event);
  }
}

void SickDriver::on_reply(const Event& event) {
  if (phase_ == Phase::finding && event.code() == kValuesReply) {
    // It streams at this speed: "stop" is said again if it was not heard.
    if (!std::exchange(streams_here_, true)) deadline_ = clock_() + kStopPatience;
    return;
  }
  const bool rejected = event.code() == kRejectedReply;
  if (!rejected && event.code() != reply_code_of(phase_)) return;
  if (rejected || read_reply(event) == Answer::refused) {
    start_over(phase_ == Phase::entering_installation ? "the laser refused the password"
                                                      : "the laser refused a command");
    return;
  }
  enter(phase_after(phase_));
}

void SickDriver::on_timeout() {
  if (phase_ == Phase::finding) {
    const bool streams = std::exchange(streams_here_, false);
    const bool acknowledged = std::exchange(acknowledged_, false);
    return streams || acknowledged ? ask() : look_elsewhere();
  }
  // Only the answer may be lost, and the laser be at its new speed already.
  if (phase_ == Phase::changing_baud) return start_over("no answer to the change of speed");
  if (tries_ < kTries) return ask();
  if (phase_ == Phase::checking_baud && ++baud_failures_ >= 2) {
    goal_baud_ = 9600;
    return start_over("no answer at " + std::to_string(options_.baud) + " baud: stays at 9600");
  }
  start_over("the laser stopped answering");
}

void SickDriver::stop() { send(set_mode_request(kOnRequest)); }

}  // namespace marco::drivers::sick
