#include "drivers/hokuyo/driver.hpp"

#include <cstdio>

#include "drivers/laser/laser_state.hpp"
#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::hokuyo {
namespace {

constexpr Duration kPatience = Duration::from_us(250'000);
constexpr int kTries = 3;
constexpr int kUsbBaud = 115'200;  // without effect there, but a terminal needs one
constexpr const char* kUnknown = "0E";
constexpr std::size_t kLongestReplyBytes = 2500;

}  // namespace

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
