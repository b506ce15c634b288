#include "drivers/ydlidar/driver.hpp"

#include "common/pose2.hpp"
#include "drivers/laser/laser_state.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers::ydlidar {
namespace {

constexpr Duration kForceStopPause = Duration::from_us(5'000);
constexpr Duration kStopPause = Duration::from_us(30'000);
constexpr Duration kPatience = Duration::from_us(300'000);
constexpr Duration kStartPatience = Duration::from_us(1'500'000);  // the motor starts as well
constexpr Duration kResetPause = Duration::from_us(1'000'000);
constexpr Duration kSilence = Duration::from_us(500'000);
constexpr int kTries = 3;
// Noise makes a packet now and then, not several in a row.
constexpr int kTalks = 3;
constexpr double kLearnS = 1.0;  // of arrivals, which jitter by some milliseconds

}  // namespace

YdlidarDriver::YdlidarDriver(ByteStream& stream, const YdlidarOptions& options, Clock clock)
    : Dialogue(stream, std::move(clock), PacketTurns::Timing{false, kLearnS}),
      options_(options),
      search_(128'000, {230'400, 115'200, 512'000}) {
  validate(options, "ydlidar");
  try_next_speed();
}

LaserProperties YdlidarDriver::properties() const {
  return {scans_.turn_s(), options_.range_min_m, options_.range_max_m, options_.range_sigma_m};
}

void YdlidarDriver::send(uint8_t command) { stream_.write(encode_request(command)); }

void YdlidarDriver::try_next_speed() {
  set_speed(search_.next());
  parser_.clear();
  scans_.restart();
  info_.reset();
  only_talks_ = false;
  tries_ = 0;
  enter(Phase::stopping);
}

void YdlidarDriver::enter(Phase phase) {
  if (phase != phase_) tries_ = 0;
  phase_ = phase;
  ++tries_;
  wait(kPatience);
  switch (phase) {
    case Phase::stopping:
      // X2 and X4 turn while DTR is raised.
      stream_.set_dtr(true);
      send(tries_ == 1 ? kForceStop : kStop);
      wait(tries_ == 1 ? kForceStopPause : kStopPause);
      break;
    case Phase::asking_info:
      unasked_packets_ = 0;
      send(kGetInfo);
      break;
    case Phase::asking_health:
      send(tries_ % 2 == 1 ? kGetHealth : kGetHealthToo);
      break;
    case Phase::starting:
      scans_.lose_count();
      send(kScan);
      wait(kStartPatience);
      break;
    case Phase::resetting:
      send(kReset);
      send(kResetToo);
      wait(kResetPause);
      break;
    case Phase::measuring:
      scans_.lose_count();
      wait(kSilence);
      break;
  }
}

void YdlidarDriver::start_over(const std::string& why) {
  trouble_ = why;
  parser_.clear();
  tries_ = 0;
  enter(Phase::stopping);
}

void YdlidarDriver::on_input_flushed() {
  scans_.lose_count();
  if (phase_ == Phase::measuring) wait(kSilence);
}

void YdlidarDriver::on_timeout() {
  switch (phase_) {
    case Phase::stopping:
      return enter(tries_ == 1 ? Phase::stopping : Phase::asking_info);
    case Phase::asking_info:
      // It sends and does not listen. A stop may have been lost, so it is repeated.
      if (unasked_packets_ >= kTalks && tries_ < kTries) {
        send(kStop);
        return enter(Phase::asking_info);
      }
      only_talks_ = unasked_packets_ >= kTalks;
      return only_talks_ ? enter(Phase::measuring) : try_next_speed();
    case Phase::asking_health:
      return enter(tries_ <= kTries ? Phase::asking_health : Phase::starting);
    case Phase::starting:
      if (tries_ < kTries) return enter(Phase::starting);
      return start_over("no samples came: does the motor turn?");
    case Phase::measuring:
      return start_over("the samples stopped");
    case Phase::resetting:
      return enter(Phase::stopping);
  }
}

void YdlidarDriver::on_answer(const Answer& answer, Utime read) {
  const Utime arrival = read - line_time(answer.bytes_after, search_.current());
  if (answer.kind == kPackets) return on_packet(answer, arrival);
  const bool is_info = answer.kind == kInfo && answer.data.size() == kInfoSize;
  if (is_info) info_ = decode_info(answer.data);
  if (is_info && phase_ == Phase::asking_info) enter(Phase::asking_health);
  if (answer.kind == kHealth && phase_ == Phase::asking_health) on_health(answer.data);
}

void YdlidarDriver::on_health(const Bytes& data) {
  if (data[0] < 2) return enter(Phase::starting);
  trouble_ = "the laser reports error " + std::to_string(data[1] | data[2] << 8);
  enter(Phase::resetting);
}

void YdlidarDriver::on_packet(const Answer& answer, Utime arrival) {
  if (phase_ == Phase::asking_info) {
    unasked_packets_ = answer.continuous ? unasked_packets_ + 1 : 0;
  }
  if (phase_ == Phase::starting) enter(Phase::measuring);
  if (phase_ != Phase::measuring) return;
  deadline_ = arrival + kSilence;
  trouble_.clear();
  SamplePacket samples;
  samples.continuous = answer.continuous;
  samples.arrival = arrival;
  samples.left = arrival - line_time(answer.size, search_.current());
  samples.clock_s = samples.left.seconds();
  const bool correct = options_.angle_correction && answer.form != SampleForm::wide_intensity;
  for (std::size_t i = 0; i < answer.packet.samples.size(); ++i) {
    const Sample& sample = answer.packet.samples[i];
    const double angle_deg = sample_angle_deg(answer.packet, i);
    const double seen_at_deg = angle_deg + (correct ? angle_correction_deg(sample.range_mm) : 0.0);
    samples.samples.push_back({angle_deg, -deg_to_rad(seen_at_deg), 1e-3 * sample.range_mm,
                               static_cast<double>(sample.intensity)});
  }
  scans_.add(samples);
}

void YdlidarDriver::stop() {
  send(kStop);
  stream_.set_dtr(false);
}

std::string YdlidarDriver::state() const {
  std::string state =
      phase_ <= Phase::asking_info ? "looking for the laser" : "setting the laser up";
  if (phase_ == Phase::measuring) {
    state = "measuring, " + describe_scans(counts(), scans_.filter()) +
            format(", %.1f a second, %.0f samples a second", 1.0 / scans_.turn_s(),
                   scans_.sample_rate_hz());
  }
  if (info_) state += ", " + model_name(info_->model);
  if (only_talks_) state += ", receives nothing";
  if (answers()) state += ", " + std::to_string(search_.current()) + " baud";
  return with_trouble(state, counts(), trouble_);
}

}  // namespace marco::drivers::ydlidar
