#include "drivers/hokuyo/driver.hpp"

#include <numbers>

#include "drivers/laser/laser_state.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers::hokuyo {
namespace {

constexpr uint32_t kStampMask = 0xFFFFFF;

constexpr Duration kPatience = Duration::from_us(250'000);
constexpr int kTries = 3;
constexpr int kUsbBaud = 115'200;  // without effect there, but a terminal needs one
constexpr const char* kUnknown = "0E";
constexpr std::size_t kLongestReplyBytes = 2500;

}  // namespace

void ScanAssembler::start(const Parameters& parameters, int cluster, int skip) {
  parameters_ = parameters;
  request_ = {true, 3, parameters.first_step, parameters.last_step, cluster, skip, 0};
}

void ScanAssembler::restart_clock() {
  filter_.reset();
  device_ms_ = 0;
}

double ScanAssembler::scan_duration_s() const {
  return step_s() * (parameters_.last_step - parameters_.first_step);
}

double ScanAssembler::from_rear_s(int step) const {
  const int rear_step = parameters_.front_step - parameters_.steps_per_turn / 2;
  return step_s() * (step - rear_step);
}

void ScanAssembler::add(const Reply& reply, Utime end, Utime arrival) {
  const auto measured = decode_measurement(reply, request_);
  if (!measured) {
    ++counts_.drops["inconsistent"];
    return;
  }
  ++counts_.scans;
  device_ms_ += device_ms_ == 0 ? 1 : (measured->timestamp_ms - last_stamp_ms_) & kStampMask;
  last_stamp_ms_ = measured->timestamp_ms;
  // The stamp is of the rear, before the first beam; the reply leaves after the last one.
  const Utime rear = end - Duration::from_seconds(from_rear_s(request_.last_step));
  const Utime filtered = filter_.update(static_cast<double>(device_ms_) * 1e-3, rear);
  ready_.push_back({scan_of(*measured, filtered), arrival});
}

LaserScan ScanAssembler::scan_of(const Measurement& measured, Utime rear) const {
  LaserScan scan;
  const double step_rad = 2.0 * std::numbers::pi / parameters_.steps_per_turn;
  // A merged beam stands for the middle of its steps.
  const double middle = 0.5 * (request_.cluster - 1);
  scan.utime = rear + Duration::from_seconds(from_rear_s(request_.first_step) + middle * step_s());
  scan.first_bearing_rad = (request_.first_step - parameters_.front_step + middle) * step_rad;
  scan.bearing_step_rad = step_rad * request_.cluster;
  const auto beyond_m = static_cast<float>(0.001 * parameters_.range_max_mm);
  const double beam_s = step_s() * request_.cluster;
  for (const uint32_t value_mm : measured.values_mm) {
    const bool code = value_mm < static_cast<uint32_t>(parameters_.range_min_mm);
    const bool beyond = value_mm > static_cast<uint32_t>(parameters_.range_max_mm);
    scan.time_offsets_s.push_back(static_cast<float>(beam_s * static_cast<double>(scan.size())));
    scan.ranges_m.push_back(code ? 0.0f : beyond ? beyond_m : static_cast<float>(value_mm * 0.001));
  }
  return scan;
}

HokuyoDriver::HokuyoDriver(ByteStream& stream, const HokuyoOptions& options, Clock clock)
    : Dialogue(stream, std::move(clock)),
      options_(options),
      search_(options.baud,
              options.baud == 0 ? std::vector<int>{}
                                : std::vector<int>{19'200, 115'200, 38'400, 57'600}) {
  validate(options, "hokuyo");
  try_next_baud_rate();
}

LaserProperties HokuyoDriver::properties() const {
  const Parameters& parameters = scans_.parameters();
  return {scans_.scan_duration_s(), 0.001 * parameters.range_min_mm,
          0.001 * parameters.range_max_mm, options_.range_sigma_m};
}

std::string HokuyoDriver::request_of(Phase phase) const {
  switch (phase) {
    case Phase::changing_baud:
      return format("SS%06d", options_.baud);
    case Phase::asking_parameters:
      return "PP";
    case Phase::laser_on:
      return "BM";
    case Phase::starting:
      return scans_.request().line();
    default:
      return "QT";
  }
}

void HokuyoDriver::enter(Phase phase) {
  phase_ = phase;
  tries_ = 0;
  if (phase == Phase::measuring) {
    scans_.restart_clock();
    wait(silence_allowed());
    trouble_.clear();
    return;
  }
  ask();
}

void HokuyoDriver::ask() {
  ++tries_;
  // Old firmware still speaks SCIP 1.1, which has no QT.
  if (phase_ == Phase::finding) send("SCIP2.0");
  send(request_of(phase_));
  wait(kPatience + line_time(300, baud_));
}

void HokuyoDriver::send(const std::string& line) {
  const std::string text = line + "\n";
  stream_.write({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

void HokuyoDriver::set_baud(int baud) {
  baud_ = baud;
  stream_.set_line({baud == 0 ? kUsbBaud : baud, Parity::none});
}

void HokuyoDriver::try_next_baud_rate() {
  set_baud(search_.next());
  stream_.discard_input();
  parser_.clear();
  enter(Phase::finding);
}

void HokuyoDriver::start_over(const std::string& why) {
  trouble_ = why;
  search_.restart();
  try_next_baud_rate();
}

Duration HokuyoDriver::silence_allowed() const {
  return Duration::from_seconds(0.5 + 3.0 * scans_.scan_period_s()) +
         line_time(kLongestReplyBytes, baud_);
}

void HokuyoDriver::on_input_flushed() {
  parser_.clear();
  if (phase_ == Phase::measuring) wait(silence_allowed());
}

void HokuyoDriver::on_timeout() {
  if (phase_ == Phase::measuring) return start_over("the scans stopped");
  if (phase_ == Phase::finding) return try_next_baud_rate();
  if (phase_ == Phase::changing_baud && tries_ >= kTries) return enter(Phase::asking_parameters);
  if (tries_ < kTries) return ask();
  start_over("the laser stopped answering");
}

void HokuyoDriver::on_answer(const Reply& reply, Utime arrival) {
  const bool is_scan = reply.status == "99";
  if (phase_ == Phase::measuring) {
    if (!is_scan) return;
    const int64_t scans = counts().scans;
    const std::size_t bytes = encode_reply(reply).size() + parser_.bytes_after();
    scans_.add(reply, arrival - line_time(bytes, baud_), arrival);
    if (counts().scans > scans) deadline_ = arrival + silence_allowed();
  } else if (!is_scan && reply.echo == request_of(phase_)) {
    on_reply(reply);
  }
}

void HokuyoDriver::on_reply(const Reply& reply) {
  switch (phase_) {
    case Phase::finding:
      // Another program has left it telling its time: it obeys nothing else.
      if (reply.status == kUnknown && tries_ < kTries) {
        send("TM2");
        return ask();
      }
      return enter(baud_ == options_.baud ? Phase::asking_parameters : Phase::changing_baud);
    case Phase::changing_baud:
      if (reply.done()) set_baud(options_.baud);
      return enter(Phase::asking_parameters);
    case Phase::asking_parameters: {
      const auto parameters = decode_parameters(reply);
      if (!parameters) return start_over("the laser's parameters are invalid");
      scans_.start(*parameters, options_.cluster, options_.skip);
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

std::string HokuyoDriver::state() const {
  std::string state;
  if (phase_ == Phase::measuring) {
    state = "measuring, " + describe_scans(counts(), scans_.filter()) + ", " +
            scans_.parameters().model;
  } else if (phase_ == Phase::finding) {
    state = "looking for the laser" + (baud_ == 0 ? "" : ", at baud " + std::to_string(baud_));
  } else {
    state = "setting the laser up, step " + std::to_string(static_cast<int>(phase_));
  }
  return with_trouble(state, counts(), trouble_);
}

}  // namespace marco::drivers::hokuyo
