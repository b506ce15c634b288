#include "drivers/rplidar/driver.hpp"

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <utility>

#include "drivers/transport/paced_output.hpp"

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
constexpr double kNoteEvery_s = 0.015;
constexpr std::size_t kMaxSamples = 20'000;

}  // namespace

RplidarDriver::RplidarDriver(ByteStream& stream, const RplidarOptions& options, Clock clock)
    : stream_(stream), options_(options), clock_(std::move(clock)) {
  validate(options, "rplidar");
  require(options.mode == "express" || options.mode == "standard",
          "RPLIDAR mode is 'express' or 'standard', not '" + options.mode + "'");
  constexpr std::array kRates{115'200, 256'000, 460'800, 1'000'000};
  require(std::find(kRates.begin(), kRates.end(), options.baud) != kRates.end(),
          "RPLIDAR baud is 115200 (A1, A2), 256000 (A2M7, A2M12, A3, S1), 460800 (C1) or 1000000 "
          "(S2, S3), not " +
              std::to_string(options.baud));
  express_ = options.mode == "express";
  stream_.set_line({options.baud, Parity::none});
  enter(Phase::stopping);
}

LaserSight RplidarDriver::sight() const {
  return {turn_s_, options_.range_min_m, options_.range_max_m, options_.range_sigma_m};
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
      // An A1 turns while DTR is low, an A2 by its board's command, which an A1 does not mind.
      stream_.set_dtr(false);
      stream_.write(motor_request(options_.motor_pwm));
      stream_.write(express_ ? encode_request(kExpressScan, Bytes(5, 0)) : encode_request(kScan));
      deadline_ = clock_() + kStartPatience;
      sample_ = last_noted_sample_ = 0;
      noted_s_ = -1.0;
      filter_.reset();
      capsule_.reset();
      turn_.reset();
      usual_span_deg_ = 0.0;
      break;
    case Phase::resetting:
      stream_.write(encode_request(kReset));
      deadline_ = clock_() + kResetPause;
      break;
    case Phase::measuring:
      break;
  }
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
    if (clock_() - last_block_ > kSilence) start_over("no samples came any more");
  } else if (clock_() >= deadline_) {
    on_timeout();
  }
  counts_.garbage_bytes = parser_.garbage_bytes();
  if (parser_.bad_checksums() > 0) counts_.drops["bad_checksum"] = parser_.bad_checksums();
  return std::exchange(ready_, {});
}

void RplidarDriver::on_line_emptied() {
  capsule_.reset();
  lose_count();
  last_block_ = clock_();
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
    last_block_ = arrival;
    trouble_.clear();
    const Utime arrived = arrival - line_time(block.bytes_after, options_.baud);
    return block.kind == kNodes ? on_node(block, arrived) : on_capsule(block, arrived);
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
    if (standard_us > 0) standard_s_ = standard_us * 1e-6;
    if (express_us > 0) express_s_ = express_us * 1e-6;
    enter(Phase::starting);
  }
}

// ---- samples -----------------------------------------------------------------------------------

void RplidarDriver::note_arrival(Utime arrival) {
  last_arrival_ = arrival;
  const double device_s = static_cast<double>(sample_) * sample_s();
  if (device_s - noted_s_ < kNoteEvery_s) return;
  noted_s_ = device_s;
  last_sample_utime_ = filter_.update(device_s, arrival);
  last_noted_sample_ = sample_;
}

void RplidarDriver::lose_count() {
  filter_.reset();
  noted_s_ = -1.0;
  usual_span_deg_ = 0.0;
  turn_.reset();
}

void RplidarDriver::on_node(const Block& block, Utime arrival) {
  if (!block.continuous) {
    // How many samples were lost is not known: the clock starts anew, and with it the turn.
    ++counts_.drops["lost_samples"];
    lose_count();
  }
  ++sample_;
  // The last of those that came together waited least.
  const bool last = block.bytes_after < 2 * kNodeSize;
  if (last) note_arrival(arrival - line_time(kNodeSize, options_.baud));
  const Node& node = block.node;
  const double range_m = node.quality > 0 ? node.distance_q2 * 0.25e-3 : 0.0;
  add_sample(node.angle_q6 / 64.0, range_m, node.first);
}

// A capsule lost without a trace doubles the step of the start angles.
bool RplidarDriver::spans_one(const Capsule& next) {
  double span_deg = (next.start_q6 - capsule_->start_q6) / 64.0;
  if (span_deg < 0.0) span_deg += 360.0;
  if (usual_span_deg_ == 0.0) usual_span_deg_ = span_deg;
  if (span_deg > 1.6 * usual_span_deg_ || span_deg < 0.4 * usual_span_deg_) return false;
  usual_span_deg_ += 0.1 * (span_deg - usual_span_deg_);
  return true;
}

void RplidarDriver::on_capsule(const Block& block, Utime arrival) {
  const std::optional<Capsule> previous = capsule_;
  const bool whole =
      !previous || (block.continuous && !block.capsule.first && spans_one(block.capsule));
  if (!whole) {
    ++counts_.drops["lost_capsule"];
    lose_count();
  }
  if (previous && whole) {
    for (int k = 0; k < kCapsuleSamples; ++k) {
      const double angle_deg = sample_angle_deg(*previous, block.capsule, k);
      ++sample_;
      // Offsets shift a sample back by some degrees: only a long way back is a new turn.
      const bool new_turn = angle_deg < last_angle_deg_ - 180.0;
      add_sample(angle_deg, previous->distance_mm[static_cast<std::size_t>(k)] * 1e-3, new_turn);
    }
  }
  capsule_ = block.capsule;
  // It leaves the laser after its own last sample, 32 behind the one counted.
  note_arrival(arrival - line_time(kCapsuleSize, options_.baud) -
               Duration::from_seconds(kCapsuleSamples * sample_s()));
}

void RplidarDriver::add_sample(double angle_deg, double range_m, bool new_turn) {
  last_angle_deg_ = angle_deg;
  if (new_turn) {
    finish_turn();
    turn_.emplace();
    turn_samples_.clear();
  }
  if (!turn_ || turn_->size() >= kMaxSamples) return;
  turn_->ranges_m.push_back(static_cast<float>(range_m));
  double bearing_rad = -angle_deg * std::numbers::pi / 180.0;
  if (bearing_rad < -std::numbers::pi) bearing_rad += 2.0 * std::numbers::pi;
  turn_->bearings_rad.push_back(static_cast<float>(bearing_rad));
  turn_samples_.push_back(sample_ - 1);
}

void RplidarDriver::finish_turn() {
  if (!turn_ || turn_->size() < 2) return;
  const double host_sample_s = sample_s() / (1.0 + filter_.drift());
  // Sample n is measured one period before the count n + 1 is reached.
  const auto time_of = [&](int64_t sample) {
    return last_sample_utime_ +
           Duration::from_seconds(static_cast<double>(sample - last_noted_sample_) * host_sample_s);
  };
  LaserScan scan = std::move(*turn_);
  turn_.reset();
  scan.channel = "LIDAR_RAW";
  scan.utime = time_of(turn_samples_.front());
  for (const int64_t sample : turn_samples_) {
    scan.time_offsets_s.push_back(
        static_cast<float>(static_cast<double>(sample - turn_samples_.front()) * host_sample_s));
  }
  turn_s_ = static_cast<double>(scan.time_offsets_s.back());
  ++counts_.scans;
  ready_.push_back({std::move(scan), last_arrival_});
}

void RplidarDriver::stop() {
  stream_.write(encode_request(kStop));
  stream_.write(motor_request(0));
  stream_.set_dtr(true);
}

std::string RplidarDriver::state() const {
  char text[160];
  if (phase_ == Phase::measuring) {
    std::snprintf(
        text, sizeof(text), "measuring, %s, %lld scans, %.1f a second, jitter %.2f ms, max %.2f ms",
        express_ ? "express" : "standard", static_cast<long long>(counts_.scans),
        turn_s_ > 0.0 ? 1.0 / turn_s_ : 0.0, filter_.jitter_s() * 1e3, filter_.max_delay_s() * 1e3);
  } else {
    std::snprintf(text, sizeof(text), "%s",
                  phase_ <= Phase::asking_info ? "looking for the laser" : "setting the laser up");
  }
  std::string line = text;
  if (model_ != 0) line += ", model " + std::to_string(model_);
  if (counts_.garbage_bytes > 0) line += ", garbage bytes " + std::to_string(counts_.garbage_bytes);
  if (!trouble_.empty()) line += ", " + trouble_;
  return line;
}

}  // namespace marco::drivers::rplidar
