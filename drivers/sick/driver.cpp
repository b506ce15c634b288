#include "drivers/sick/driver.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::sick {
namespace {

using std::chrono::microseconds;
constexpr double kTurnS = 1.0 / 75.0;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr microseconds kStep{50'000};
constexpr Duration kAckPatience = Duration::from_us(120'000);  // the device's promise: 60 ms
constexpr Duration kModePatience = Duration::from_us(3'200'000);
constexpr Duration kReplyPatience = Duration::from_us(1'000'000);
constexpr Duration kConfigurePatience = Duration::from_us(15'000'000);
constexpr Duration kSettle = Duration::from_us(250'000);
constexpr Duration kByteGap = Duration::from_us(30'000);  // the device's promise: 14 ms
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
      turns_(kTurnS) {
  validate(options, "sick");
  require(mode_of_baud(options.baud).has_value(),
          "SICK baud is 9600, 19200, 38400 or 500000; not " + std::to_string(options.baud));
  require(beams_of_variant(options.angle_deg, resolution_cdeg()) > 0,
          "the laser has no variant of " + std::to_string(options.angle_deg) + " deg by " +
              std::to_string(options.resolution_deg) + " deg");
  require(options.password.size() == 8, "the laser's password has 8 characters");
  turns_ = TurnCounter(scan_period_s());
  look_elsewhere();
}

int SickDriver::resolution_cdeg() const {
  return static_cast<int>(std::lround(options_.resolution_deg * 100.0));
}

int SickDriver::turns_per_scan() const { return options_.interlaced ? 1 : 100 / resolution_cdeg(); }

double SickDriver::scan_period_s() const { return turns_per_scan() * kTurnS; }

LaserSight SickDriver::sight() const {
  const double fan_s = options_.angle_deg / 360.0 * kTurnS;
  return {(turns_per_scan() - 1) * kTurnS + fan_s, options_.range_min_m,
          range_rule(measuring_mode_).first_special * metres(unit_), options_.range_sigma_m};
}

// ---- asking ------------------------------------------------------------------------------------

Bytes SickDriver::request_of(Phase phase) const {
  switch (phase) {
    case Phase::changing_baud:
      return set_mode_request(*mode_of_baud(goal_baud_));
    case Phase::asking_type:
      return encode_request(Bytes{kGetType});
    case Phase::checking_baud:
    case Phase::asking_status:
      return encode_request(Bytes{kGetStatus});
    case Phase::setting_variant:
      return set_variant_request(options_.angle_deg, resolution_cdeg());
    case Phase::reading_configuration:
      return encode_request(Bytes{kGetConfiguration});
    case Phase::entering_installation:
      return installation_request(options_.password);
    case Phase::configuring:
      return set_configuration_request(wanted_);
    case Phase::starting:
      return set_mode_request(options_.interlaced ? kPartialScans : kContinuous);
    default:
      return set_mode_request(kOnRequest);
  }
}

uint8_t SickDriver::reply_code_of(Phase phase) const {
  return static_cast<uint8_t>(request_of(phase)[4] | 0x80);
}

Duration SickDriver::patience_of(Phase phase) const {
  if (phase == Phase::finding) return kAckPatience + line_time(20, baud_);
  if (phase == Phase::configuring) return kConfigurePatience;
  const bool mode_change = reply_code_of(phase) == (kSetMode | 0x80);
  return (mode_change ? kModePatience : kReplyPatience) + line_time(200, baud_);
}

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
  }
  while (const auto event = parser_.next()) on_event(*event, arrival);
}

void SickDriver::on_event(const Event& event, Utime arrival) {
  if (event.kind == Event::Kind::bad_checksum) {
    if (phase_ == Phase::measuring) ++counts_.drops["bad_checksum"];
    return;
  }
  if (event.kind == Event::Kind::ack) {
    // Heard at this speed: a change of mode may take the laser three seconds.
    if (phase_ == Phase::finding && parser_.garbage_bytes() == counts_.garbage_bytes) {
      deadline_ = std::max(deadline_, clock_() + kModePatience);
    }
    return;
  }
  if (event.kind == Event::Kind::nak) {
    if (phase_ != Phase::measuring) deadline_ = std::min(deadline_, clock_() + kByteGap);
    return;
  }
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
    // It streams at this speed; it will hear "stop" between two scans.
    deadline_ = clock_() + kModePatience;
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

SickDriver::Answer SickDriver::read_reply(const Event& event) {
  const std::span<const uint8_t> data = event.data();
  const auto answer = [](bool good) { return good ? Answer::good : Answer::refused; };
  switch (event.code()) {
    case kSetMode | 0x80:
      return answer(!data.empty() && data[0] == 0);
    case kSetVariant | 0x80:
      return answer(!data.empty() && data[0] == 1);
    case kGetType | 0x80:
      type_.assign(data.begin(), data.end());
      return Answer::good;
    case kGetStatus | 0x80: {
      const auto report = decode_status(event);
      if (report && report->defect) trouble_ = "the laser reports a defect";
      return Answer::good;
    }
    case kGetConfiguration | 0x80: {
      const auto read = decode_configuration(event);
      if (!read) return Answer::refused;
      wanted_ = *read;
      wanted_.set_measuring(measuring_mode_, unit_);
      configured_ = wanted_ == *read;
      return Answer::good;
    }
    case kSetConfiguration | 0x80: {
      const bool echoed =
          data.size() >= 8 && data[1 + 5] == wanted_.bytes[5] && data[1 + 6] == wanted_.bytes[6];
      return answer(!data.empty() && data[0] == 1 && echoed);
    }
    default:
      return Answer::good;
  }
}

SickDriver::Phase SickDriver::phase_after(Phase phase) const {
  switch (phase) {
    case Phase::finding:
      return baud_ == goal_baud_ ? Phase::asking_type : Phase::changing_baud;
    case Phase::changing_baud:
      return Phase::settling;
    case Phase::checking_baud:
      return Phase::asking_type;
    case Phase::asking_type:
      return Phase::asking_status;
    case Phase::asking_status:
      return Phase::setting_variant;
    case Phase::setting_variant:
      return Phase::reading_configuration;
    case Phase::reading_configuration:
      return configured_ ? Phase::starting : Phase::entering_installation;
    case Phase::entering_installation:
      return Phase::configuring;
    case Phase::configuring:
      return Phase::leaving_installation;
    case Phase::leaving_installation:
      return Phase::starting;
    default:
      return Phase::measuring;
  }
}

void SickDriver::on_timeout() {
  if (phase_ == Phase::finding) return look_elsewhere();
  if (tries_ < kTries) return ask();
  if (phase_ == Phase::checking_baud && ++baud_failures_ >= 2) {
    goal_baud_ = 9600;
    return start_over("no answer at " + std::to_string(options_.baud) + " baud: stays at 9600");
  }
  start_over("the laser stopped answering");
}

// ---- measuring ---------------------------------------------------------------------------------

void SickDriver::on_values(const Event& event, Utime arrival) {
  const auto values = decode_values(event);
  if (!values) {
    ++counts_.drops["inconsistent"];
    return;
  }
  const int beams = beams_of_variant(options_.angle_deg, resolution_cdeg());
  const bool partial_ok = values->partial && options_.interlaced &&
                          static_cast<int>(values->words.size()) >= options_.angle_deg;
  if (!partial_ok && static_cast<int>(values->words.size()) != beams) {
    ++counts_.drops["other_variant"];
    return;
  }
  if (values->unit != unit_) {
    ++counts_.drops["other_unit"];
    return;
  }
  if ((event.status() & 7) == 4) {
    ++counts_.drops["fatal_status"];
    return;
  }
  last_scan_ = arrival;
  ++counts_.scans;
  const Utime end = arrival - line_time(event.bytes_total, baud_);
  const Utime filtered = filter_.update(turns_.update(end), end);
  ready_.push_back(to_scan(*values, filtered - Duration::from_seconds(scan_period_s()), arrival));
}

ArrivedScan SickDriver::to_scan(const MeasuredValues& values,
                                Utime first_beam,
                                Utime arrival) const {
  const RangeRule rule = range_rule(measuring_mode_);
  const double metre = metres(values.unit);
  const auto beyond_m = static_cast<float>(rule.first_special * metre);
  ArrivedScan arrived;
  arrived.arrival = arrival;
  LaserScan& scan = arrived.scan;
  const double offset_deg = values.partial ? 0.25 * values.partial_offset_quarters : 0.0;
  const double step_deg = values.partial ? 1.0 : 0.01 * resolution_cdeg();
  const int turns = turns_per_scan();
  scan.utime = first_beam + Duration::from_seconds(offset_deg / 360.0 * kTurnS);
  scan.first_bearing_rad = (-0.5 * options_.angle_deg + offset_deg) * kRadPerDeg;
  scan.bearing_step_rad = step_deg * kRadPerDeg;
  scan.ranges_m.reserve(values.words.size());
  scan.time_offsets_s.reserve(values.words.size());
  for (std::size_t i = 0; i < values.words.size(); ++i) {
    const auto special = special_of(values.words[i], rule);
    float range_m = static_cast<float>((values.words[i] & rule.distance_mask) * metre);
    if (special) {
      const bool nothing_there = *special == Special::no_echo || *special == Special::beyond_range;
      range_m = nothing_there ? beyond_m : 0.0f;
    }
    scan.ranges_m.push_back(range_m);
    const double in_turn_s = static_cast<double>(i) * step_deg / 360.0 * kTurnS;
    scan.time_offsets_s.push_back(
        static_cast<float>(in_turn_s + static_cast<double>(i % turns) * kTurnS));
  }
  return arrived;
}

void SickDriver::stop() { send(set_mode_request(kOnRequest)); }

std::string SickDriver::state() const {
  char text[200];
  const std::string complaint = describe_status_byte(status_);
  if (phase_ == Phase::measuring) {
    std::snprintf(text, sizeof(text),
                  "measuring at %d baud%s%s, %lld scans, jitter %.2f ms, max %.2f ms", baud_,
                  complaint.empty() ? "" : " with ", complaint.c_str(),
                  static_cast<long long>(counts_.scans), filter_.jitter_s() * 1e3,
                  filter_.max_delay_s() * 1e3);
  } else if (phase_ == Phase::finding) {
    std::snprintf(text, sizeof(text), "looking for the laser, at %d baud", baud_);
  } else {
    std::snprintf(text, sizeof(text), "setting the laser up, step %d", static_cast<int>(phase_));
  }
  std::string line = text;
  if (!type_.empty()) line += ", " + type_;
  if (counts_.garbage_bytes > 0) line += ", garbage bytes " + std::to_string(counts_.garbage_bytes);
  if (!trouble_.empty()) line += ", " + trouble_;
  return line;
}

}  // namespace marco::drivers::sick
