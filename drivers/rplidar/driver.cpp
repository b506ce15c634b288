#include "drivers/rplidar/driver.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "drivers/laser/laser_state.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::rplidar {
namespace {

using std::chrono::microseconds;
constexpr microseconds kStep{50'000};
constexpr Duration kStopPause = Duration::from_us(20'000);
constexpr Duration kPatience = Duration::from_us(300'000);
constexpr Duration kStartPatience = Duration::from_us(1'000'000);
constexpr Duration kResetPause = Duration::from_us(1'000'000);
constexpr Duration kSilence = Duration::from_us(500'000);
constexpr int kTries = 3;

}  // namespace

RplidarDriver::RplidarDriver(ByteStream& stream, const RplidarOptions& options, Clock clock)
    : stream_(stream),
      options_(options),
      clock_(std::move(clock)),
      turns_(options.baud),
      express_(options.mode == "express") {
  validate(options, "rplidar");
  require(express_ || options.mode == "standard",
          "RPLIDAR mode is 'express' or 'standard', not '" + options.mode + "'");
  constexpr std::array kRates{115'200, 256'000, 460'800, 1'000'000};
  require(std::find(kRates.begin(), kRates.end(), options.baud) != kRates.end(),
          "RPLIDAR baud is 115200 (A1, A2), 256000 (A2M7, A2M12, A3, S1), 460800 (C1) or 1000000 "
          "(S2, S3), not " +
              std::to_string(options.baud));
  stream_.set_line({options.baud, Parity::none});
  enter(Phase::stopping);
}

LaserProperties RplidarDriver::properties() const {
  return {turns_.turn_s(), options_.range_min_m, options_.range_max_m, options_.range_sigma_m};
}

void RplidarDriver::enter(Phase phase) {
  if (phase != phase_) tries_ = 0;
  phase_ = phase;
  ++tries_;
  parser_.expect_descriptor();
  deadline_ = clock_() + kPatience;
  switch (phase) {
    case Phase::stopping:
      stream_.write(encode_request(kStop));
      deadline_ = clock_() + kStopPause;
      break;
    case Phase::asking_info:
      stream_.write(encode_request(kGetInfo));
      break;
    case Phase::asking_health:
      stream_.write(encode_request(kGetHealth));
      break;
    case Phase::asking_rate:
      stream_.write(encode_request(kGetSampleRate));
      break;
    case Phase::starting:
      start_scan();
      break;
    case Phase::resetting:
      stream_.write(encode_request(kReset));
      deadline_ = clock_() + kResetPause;
      break;
    case Phase::measuring:
      break;
  }
}

void RplidarDriver::start_scan() {
  // An A1 turns while DTR is low, an A2 when its board is told to. An A1 ignores that request.
  stream_.set_dtr(false);
  stream_.write(motor_request(options_.motor_pwm));
  stream_.write(express_ ? encode_request(kExpressScan, Bytes(5, 0)) : encode_request(kScan));
  deadline_ = clock_() + kStartPatience;
  turns_.start(express_ ? periods_.express_s : periods_.standard_s);
}

void RplidarDriver::start_over(const std::string& why) {
  trouble_ = why;
  enter(Phase::stopping);
}

std::vector<ArrivedScan> RplidarDriver::step() {
  microseconds wait = kStep;
  if (phase_ != Phase::measuring) {
    wait = std::clamp(microseconds((deadline_ - clock_()).us), microseconds(0), kStep);
  }
  uint8_t buffer[8192];
  const std::size_t count = stream_.read(buffer, wait);
  const Utime arrival = clock_();
  if (phase_ != Phase::stopping && phase_ != Phase::resetting) {
    parser_.push({buffer, count});
    const Phase phase = phase_;
    while (const auto block = parser_.next()) {
      on_block(*block, arrival);
      if (phase_ != phase && phase_ != Phase::measuring) break;
    }
  }
  if (phase_ == Phase::measuring) {
    if (clock_() > deadline_) start_over("the samples stopped");
  } else if (clock_() >= deadline_) {
    on_timeout();
  }
  LaserCounts& counts = turns_.counts();
  counts.garbage_bytes = parser_.garbage_bytes();
  if (parser_.bad_checksums() > 0) counts.drops["bad_checksum"] = parser_.bad_checksums();
  return turns_.take_scans();
}

void RplidarDriver::on_input_flushed() {
  turns_.lose_count();
  if (phase_ == Phase::measuring) deadline_ = clock_() + kSilence;
}

void RplidarDriver::on_timeout() {
  if (phase_ == Phase::stopping) return enter(Phase::asking_info);
  if (phase_ == Phase::resetting) return enter(Phase::stopping);
  if (phase_ == Phase::asking_rate) return enter(Phase::starting);  // old firmware has no answer
  if (phase_ == Phase::starting && express_ && tries_ >= kTries) {
    express_ = false;
    return start_over("no express scan: standard");
  }
  if (tries_ < kTries) return enter(phase_);
  start_over("the laser does not answer");
}

void RplidarDriver::on_block(const Block& block, Utime arrival) {
  if (block.kind == kNodes || block.kind == kCapsules) {
    if (phase_ == Phase::starting) phase_ = Phase::measuring;
    if (phase_ != Phase::measuring) return;
    deadline_ = arrival + kSilence;
    trouble_.clear();
    const Utime last_byte = arrival - line_time(block.bytes_after, options_.baud);
    return block.kind == kNodes ? turns_.add_node(block, last_byte)
                                : turns_.add_capsule(block, last_byte);
  }
  on_answer(block);
}

void RplidarDriver::on_answer(const Block& block) {
  if (phase_ == Phase::asking_info && block.kind == kInfo && block.data.size() == 20) {
    model_ = block.data[0];
    enter(Phase::asking_health);
  } else if (phase_ == Phase::asking_health && block.kind == kHealth && block.data.size() == 3) {
    if (block.data[0] == 2) {
      trouble_ = "the laser reports error " + std::to_string(block.data[1] | block.data[2] << 8);
      return enter(Phase::resetting);
    }
    enter(Phase::asking_rate);
  } else if (phase_ == Phase::asking_rate && block.kind == kSampleRate && block.data.size() == 4) {
    const int standard_us = block.data[0] | block.data[1] << 8;
    const int express_us = block.data[2] | block.data[3] << 8;
    if (standard_us > 0) periods_.standard_s = standard_us * 1e-6;
    if (express_us > 0) periods_.express_s = express_us * 1e-6;
    enter(Phase::starting);
  }
}

void RplidarDriver::stop() {
  stream_.write(encode_request(kStop));
  stream_.write(motor_request(0));
  stream_.set_dtr(true);
}

std::string RplidarDriver::state() const {
  std::string state =
      phase_ <= Phase::asking_info ? "looking for the laser" : "setting the laser up";
  if (phase_ == Phase::measuring) {
    char rate[32];
    std::snprintf(rate, sizeof(rate), "%.1f a second",
                  turns_.turn_s() > 0.0 ? 1.0 / turns_.turn_s() : 0.0);
    state = std::string("measuring, ") + (express_ ? "express" : "standard") + ", " +
            describe_scans(counts(), turns_.filter()) + ", " + rate;
  }
  if (model_ != 0) state += ", model " + std::to_string(model_);
  return with_trouble(state, counts(), trouble_);
}

}  // namespace marco::drivers::rplidar
