#include "drivers/hokuyo/driver.hpp"

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <utility>

#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::hokuyo {
namespace {

using std::chrono::microseconds;
constexpr microseconds kStep{50'000};
constexpr Duration kPatience = Duration::from_us(250'000);
constexpr int kTries = 3;
constexpr int kUsbBaud = 115'200;  // means nothing there, but a terminal has one
constexpr uint32_t kStampMask = 0xFFFFFF;

}  // namespace

HokuyoDriver::HokuyoDriver(ByteStream& stream, const HokuyoOptions& options, Clock clock)
    : stream_(stream), options_(options), clock_(std::move(clock)), filter_(0.001) {
  validate(options, "hokuyo");
  rates_.push_back(options.baud);
  for (const int rate : {19'200, 115'200, 38'400, 57'600}) {
    if (options.baud != 0 && rate != options.baud) rates_.push_back(rate);
  }
  look_elsewhere();
}

LaserSight HokuyoDriver::sight() const {
  return {turn_s() * (parameters_.last_step - parameters_.first_step) / parameters_.steps_per_turn,
          0.001 * parameters_.range_min_mm, 0.001 * parameters_.range_max_mm,
          options_.range_sigma_m};
}

double HokuyoDriver::from_rear_s(int step) const {
  const int from_rear = step - parameters_.front_step + parameters_.steps_per_turn / 2;
  return turn_s() * from_rear / parameters_.steps_per_turn;
}

std::string HokuyoDriver::request_of(Phase phase) const {
  switch (phase) {
    case Phase::changing_baud: {
      char text[16];
      std::snprintf(text, sizeof(text), "SS%06d", options_.baud);
      return text;
    }
    case Phase::asking_parameters:
      return "PP";
    case Phase::laser_on:
      return "BM";
    case Phase::starting:
      return request_.line();
    default:
      return "QT";
  }
}

void HokuyoDriver::enter(Phase phase) {
  phase_ = phase;
  tries_ = 0;
  if (phase == Phase::measuring) {
    filter_.reset();
    device_ms_ = 0;
    last_scan_ = clock_();
    trouble_.clear();
    return;
  }
  ask();
}

void HokuyoDriver::ask() {
  ++tries_;
  // An old device may still speak SCIP 1.1, in which QT means nothing.
  if (phase_ == Phase::finding) send("SCIP2.0");
  send(request_of(phase_));
  deadline_ = clock_() + kPatience + line_time(300, baud_);
}

void HokuyoDriver::send(const std::string& line) {
  const std::string text = line + "\n";
  stream_.write({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

void HokuyoDriver::set_baud(int baud) {
  baud_ = baud;
  stream_.set_line({baud == 0 ? kUsbBaud : baud, Parity::none});
}

void HokuyoDriver::look_elsewhere() {
  if (std::exchange(looked_, true)) rate_ = (rate_ + 1) % rates_.size();
  set_baud(rates_[rate_]);
  stream_.discard_input();
  parser_.clear();
  enter(Phase::finding);
}

void HokuyoDriver::start_over(const std::string& why) {
  trouble_ = why;
  rate_ = rates_.size() - 1;
  look_elsewhere();
}

std::vector<ArrivedScan> HokuyoDriver::step() {
  microseconds wait = kStep;
  if (phase_ != Phase::measuring) {
    wait = std::clamp(microseconds((deadline_ - clock_()).us), microseconds(0), kStep);
  }
  uint8_t buffer[8192];
  const std::size_t count = stream_.read(buffer, wait);
  const Utime arrival = clock_();
  parser_.push({buffer, count});
  while (const auto reply = parser_.next()) on_reply(*reply, arrival);
  if (phase_ == Phase::measuring) {
    if ((clock_() - last_scan_).seconds() >
        0.5 + 3.0 * turn_s() * (1 + options_.skip) + line_time(2500, baud_).seconds()) {
      start_over("no scans came any more");
    }
  } else if (clock_() >= deadline_) {
    on_timeout();
  }
  counts_.garbage_bytes = parser_.garbage_bytes();
  if (parser_.bad_checksums() > 0) counts_.drops["bad_checksum"] = parser_.bad_checksums();
  return std::exchange(ready_, {});
}

void HokuyoDriver::on_line_emptied() {
  parser_.clear();
  last_scan_ = clock_();
}

void HokuyoDriver::on_timeout() {
  if (phase_ == Phase::finding) return look_elsewhere();
  if (phase_ == Phase::changing_baud && tries_ >= kTries) return enter(Phase::asking_parameters);
  if (tries_ < kTries) return ask();
  start_over("the laser stopped answering");
}

void HokuyoDriver::on_reply(const Reply& reply, Utime arrival) {
  const bool is_scan = reply.status == "99";
  if (phase_ == Phase::measuring) {
    if (is_scan) on_measurement(reply, arrival);
  } else if (!is_scan && reply.echo == request_of(phase_)) {
    on_answer(reply);
  }
}

void HokuyoDriver::on_answer(const Reply& reply) {
  switch (phase_) {
    case Phase::finding:
      return enter(baud_ == options_.baud ? Phase::asking_parameters : Phase::changing_baud);
    case Phase::changing_baud:
      if (reply.done()) set_baud(options_.baud);
      return enter(Phase::asking_parameters);
    case Phase::asking_parameters: {
      const auto parameters = decode_parameters(reply);
      if (!parameters) return start_over("the laser's parameters make no sense");
      parameters_ = *parameters;
      request_ = {true,          3, parameters_.first_step, parameters_.last_step, options_.cluster,
                  options_.skip, 0};
      return enter(Phase::laser_on);
    }
    case Phase::laser_on:
      if (!reply.done() && reply.status != "02") return start_over("the laser does not switch on");
      return enter(Phase::starting);
    default:
      if (!reply.done()) return start_over("the laser refused to measure: " + reply.status);
      return enter(Phase::measuring);
  }
}

void HokuyoDriver::on_measurement(const Reply& reply, Utime arrival) {
  const auto measured = decode_measurement(reply, request_);
  if (!measured) {
    ++counts_.drops["inconsistent"];
    return;
  }
  last_scan_ = arrival;
  ++counts_.scans;
  device_ms_ += device_ms_ == 0 ? 1 : (measured->timestamp_ms - last_stamp_ms_) & kStampMask;
  last_stamp_ms_ = measured->timestamp_ms;
  const std::size_t bytes = encode_reply(reply).size();
  const Utime stamped = arrival - line_time(bytes + parser_.bytes_after(), baud_) -
                        Duration::from_seconds(from_rear_s(request_.last_step));
  const Utime rear = filter_.update(static_cast<double>(device_ms_) * 1e-3, stamped);

  ArrivedScan arrived;
  arrived.arrival = arrival;
  LaserScan& scan = arrived.scan;
  const double step_rad = 2.0 * std::numbers::pi / parameters_.steps_per_turn;
  scan.utime = rear + Duration::from_seconds(from_rear_s(request_.first_step));
  scan.first_bearing_rad = (request_.first_step - parameters_.front_step) * step_rad;
  scan.bearing_step_rad = step_rad * request_.cluster;
  const auto beyond_m = static_cast<float>(0.001 * parameters_.range_max_mm);
  for (const uint32_t value_mm : measured->values_mm) {
    const bool code = value_mm < static_cast<uint32_t>(parameters_.range_min_mm);
    const bool beyond = value_mm > static_cast<uint32_t>(parameters_.range_max_mm);
    scan.ranges_m.push_back(code ? 0.0f : beyond ? beyond_m : static_cast<float>(value_mm * 0.001));
  }
  ready_.push_back(std::move(arrived));
}

std::string HokuyoDriver::state() const {
  char text[160];
  if (phase_ == Phase::measuring) {
    std::snprintf(text, sizeof(text), "measuring, %lld scans, jitter %.2f ms, max %.2f ms",
                  static_cast<long long>(counts_.scans), filter_.jitter_s() * 1e3,
                  filter_.max_delay_s() * 1e3);
  } else if (phase_ == Phase::finding) {
    std::snprintf(text, sizeof(text), "looking for the laser%s%s", baud_ == 0 ? "" : ", at baud ",
                  baud_ == 0 ? "" : std::to_string(baud_).c_str());
  } else {
    std::snprintf(text, sizeof(text), "setting the laser up, step %d", static_cast<int>(phase_));
  }
  std::string line = text;
  if (phase_ == Phase::measuring) line += ", " + parameters_.model;
  if (counts_.garbage_bytes > 0) line += ", garbage bytes " + std::to_string(counts_.garbage_bytes);
  if (!trouble_.empty()) line += ", " + trouble_;
  return line;
}

}  // namespace marco::drivers::hokuyo
