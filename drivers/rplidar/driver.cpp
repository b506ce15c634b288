#include "drivers/rplidar/driver.hpp"

#include <algorithm>

#include "common/pose2.hpp"
#include "drivers/laser/laser_state.hpp"
#include "drivers/rplidar/model.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers::rplidar {
namespace {

constexpr Duration kStopPause = Duration::from_us(20'000);
constexpr Duration kPatience = Duration::from_us(300'000);
constexpr Duration kStartPatience = Duration::from_us(1'000'000);
constexpr Duration kResetPause = Duration::from_us(1'000'000);
constexpr Duration kSilence = Duration::from_us(500'000);
constexpr int kTries = 3;
constexpr int kSearchTries = 2;  // at each rate
constexpr int kTurnsPerMinute = 600;
constexpr int kModesFirmware = 1 * 256 + 24;
const std::vector<int> kOtherRates{460'800, 1'000'000, 256'000};

}  // namespace

void TurnAssembler::start(double sample_s) {
  clock_.start(sample_s);
  capsule_.reset();
  gatherer_.drop_turn();
  usual_span_deg_ = 0.0;
}

void TurnAssembler::note_arrival(Utime arrival) {
  last_arrival_ = arrival;
  clock_.note_arrival(arrival);
}

void TurnAssembler::lose_count() {
  clock_.lose_count();
  capsule_.reset();
  usual_span_deg_ = 0.0;
  gatherer_.drop_turn();
}

void TurnAssembler::add_node(const Block& block, Utime arrival) {
  if (!block.continuous) {
    ++counts_.drops["lost_samples"];
    lose_count();
  }
  const int64_t sample = clock_.count();
  // Of nodes that came together the last one waited least.
  const bool last = block.bytes_after < 2 * kNodeSize;
  if (last) note_arrival(arrival - line_time(kNodeSize, baud_));
  const Node& node = block.node;
  // Quality 0 says nothing: some devices send no other.
  add_sample(sample, node.angle_q6 / 64.0, node.distance_q2 * 0.25e-3, node.first);
}

// A capsule lost without a trace doubles the step of the start angles.
bool TurnAssembler::follows_directly(const Capsule& next) {
  double span_deg = (next.start_q6 - capsule_->start_q6) / 64.0;
  if (span_deg < 0.0) span_deg += 360.0;
  if (usual_span_deg_ == 0.0) usual_span_deg_ = span_deg;
  if (span_deg > 1.6 * usual_span_deg_ || span_deg < 0.4 * usual_span_deg_) return false;
  usual_span_deg_ += 0.1 * (span_deg - usual_span_deg_);
  return true;
}

void TurnAssembler::add_capsule(const Block& block, Utime arrival) {
  const std::optional<Capsule> previous = capsule_;
  const bool whole =
      !previous || (block.continuous && !block.capsule.first && follows_directly(block.capsule));
  if (!whole) {
    ++counts_.drops["lost_capsule"];
    lose_count();
  }
  if (previous && whole) {
    for (const PlacedSample& sample : samples_of(*previous, block.capsule)) {
      // Offsets shift a sample back by a few degrees. A new turn is a long way back.
      const bool new_turn = sample.angle_deg < last_angle_deg_ - 180.0;
      add_sample(clock_.count(), sample.angle_deg, sample.range_mm * 1e-3, new_turn);
    }
  }
  capsule_ = block.capsule;
  // It leaves the laser after its own last sample, a capsule behind the one counted.
  note_arrival(arrival - line_time(capsule_size(block.kind), baud_) -
               Duration::from_seconds(block.capsule.samples * clock_.sample_s()));
}

void TurnAssembler::add_sample(int64_t sample, double angle_deg, double range_m, bool new_turn) {
  last_angle_deg_ = angle_deg;
  if (new_turn && gatherer_.begin_turn(last_arrival_)) ++counts_.scans;
  gatherer_.add({sample, -deg_to_rad(angle_deg), range_m});
}

RplidarDriver::RplidarDriver(ByteStream& stream, const RplidarOptions& options, Clock clock)
    : Dialogue(stream, std::move(clock)),
      options_(options),
      search_(options.baud > 0 ? options.baud : 115'200,
              options.baud > 0 ? std::vector<int>{} : kOtherRates),
      express_(options.mode == "express") {
  validate(options, "rplidar");
  require(express_ || options.mode == "standard",
          "RPLIDAR mode is 'express' or 'standard', not '" + options.mode + "'");
  require(options.baud == 0 || options.baud == 115'200 ||
              std::find(kOtherRates.begin(), kOtherRates.end(), options.baud) != kOtherRates.end(),
          "RPLIDAR baud is 0 (searched), 115200 (A1, A2), 256000 (A2M7, A2M12, A3, S1), 460800 "
          "(C1) or 1000000 (S2, S3), not " +
              std::to_string(options.baud));
  try_next_speed();
}

void RplidarDriver::try_next_speed() {
  set_speed(search_.next());
  scans_.set_baud(search_.current());
  enter(Phase::stopping);
}

LaserProperties RplidarDriver::properties() const {
  return {scans_.turn_s(), options_.range_min_m,
          options_.range_max_m > 0.0 ? options_.range_max_m : laser_.range_max_m,
          options_.range_sigma_m};
}

void RplidarDriver::enter(Phase phase) {
  if (phase != phase_) tries_ = 0;
  phase_ = phase;
  ++tries_;
  parser_.expect_descriptor();
  wait(kPatience);
  switch (phase) {
    case Phase::stopping:
      stream_.write(encode_request(kStop));
      wait(kStopPause);
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
    case Phase::asking_mode:
    case Phase::asking_answer:
    case Phase::asking_period:
    case Phase::asking_range:
      ask_configuration(phase);
      break;
    case Phase::starting:
      start_scan();
      break;
    case Phase::resetting:
      stream_.write(encode_request(kReset));
      wait(kResetPause);
      break;
    case Phase::measuring:
      break;
  }
}

void RplidarDriver::ask_configuration(Phase phase) {
  const uint8_t key = phase == Phase::asking_mode     ? kTypicalMode
                      : phase == Phase::asking_answer ? kModeAnswer
                      : phase == Phase::asking_period ? kModeSamplePeriod
                                                      : kModeMaxRange;
  const bool of_a_mode = phase != Phase::asking_mode;
  stream_.write(configuration_request(key, of_a_mode ? std::optional(laser_.mode) : std::nullopt));
}

void RplidarDriver::start_scan() {
  // An A1 turns while DTR is low, an A2 when its board is told to, an S by its own speed, a C1 with
  // its scan. Each ignores what is not for it; newer ones are not sent what is for the older.
  stream_.set_dtr(false);
  const int family = family_of(laser_.model);
  if (family < 4) stream_.write(motor_request(options_.motor_pwm));
  if (family >= 6) stream_.write(motor_speed_request(kTurnsPerMinute));
  const Bytes mode{static_cast<uint8_t>(laser_.mode), 0, 0, 0, 0};
  stream_.write(express_ ? encode_request(kExpressScan, mode) : encode_request(kScan));
  wait(kStartPatience);
  scans_.start(express_ ? periods_.express_s : periods_.standard_s);
}

void RplidarDriver::start_over(const std::string& why) {
  trouble_ = why;
  enter(Phase::stopping);
}

void RplidarDriver::on_input_flushed() {
  scans_.lose_count();
  if (phase_ == Phase::measuring) wait(kSilence);
}

void RplidarDriver::on_timeout() {
  if (phase_ == Phase::measuring) return start_over("the samples stopped");
  if (phase_ == Phase::stopping) return enter(Phase::asking_info);
  if (phase_ == Phase::resetting) return enter(Phase::stopping);
  const bool optional = phase_ >= Phase::asking_rate && phase_ <= Phase::asking_range;
  if (optional) return enter(Phase::starting);  // old firmware has no answer
  // A laser has one speed for its life. Before it was understood the others are tried.
  if (phase_ == Phase::asking_info && laser_.model == 0 && tries_ >= kSearchTries) {
    trouble_ = "the laser does not answer";
    return try_next_speed();
  }
  if (phase_ == Phase::starting && express_ && tries_ >= kTries) {
    express_ = false;
    return start_over("no express scan: standard");
  }
  if (tries_ < kTries) return enter(phase_);
  start_over("the laser does not answer");
}

void RplidarDriver::on_answer(const Block& block, Utime arrival) {
  if (block.kind == kNodes || are_capsules(block.kind)) {
    if (phase_ == Phase::starting) phase_ = Phase::measuring;
    if (phase_ != Phase::measuring) return;
    deadline_ = arrival + kSilence;
    trouble_.clear();
    const Utime last_byte = arrival - line_time(block.bytes_after, search_.current());
    return block.kind == kNodes ? scans_.add_node(block, last_byte)
                                : scans_.add_capsule(block, last_byte);
  }
  on_reply(block);
}

void RplidarDriver::on_reply(const Block& block) {
  if (phase_ == Phase::asking_info && block.kind == kInfo && block.data.size() == 20) {
    laser_.model = block.data[0];
    laser_.firmware = block.data[2] * 256 + block.data[1];
    enter(Phase::asking_health);
  } else if (phase_ == Phase::asking_health && block.kind == kHealth && block.data.size() == 3) {
    if (block.data[0] == 2) {
      trouble_ = "the laser reports error " + std::to_string(block.data[1] | block.data[2] << 8);
      return enter(Phase::resetting);
    }
    enter(express_ && tells_modes() ? Phase::asking_mode : Phase::asking_rate);
  } else if (block.kind == kConfiguration) {
    on_configuration(block);
  } else if (phase_ == Phase::asking_rate && block.kind == kSampleRate && block.data.size() == 4) {
    const int standard_us = block.data[0] | block.data[1] << 8;
    const int express_us = block.data[2] | block.data[3] << 8;
    if (standard_us > 0) periods_.standard_s = standard_us * 1e-6;
    if (express_us > 0) periods_.express_s = express_us * 1e-6;
    enter(Phase::starting);
  }
}

// An A1 and an A2 know their one express mode without being asked.
bool RplidarDriver::tells_modes() const {
  const int family = family_of(laser_.model);
  return family >= 4 || (family == 3 && laser_.firmware >= kModesFirmware);
}

void RplidarDriver::on_configuration(const Block& block) {
  const Bytes& data = block.data;
  const auto value = [&data](std::size_t size) {
    uint32_t number = 0;
    for (std::size_t i = 0; i < size; ++i) number |= static_cast<uint32_t>(data[4 + i]) << 8 * i;
    return number;
  };
  if (phase_ == Phase::asking_mode && data.size() >= 6 && data[0] == kTypicalMode) {
    laser_.mode = static_cast<int>(value(2) & 0xFF);
    enter(Phase::asking_answer);
  } else if (phase_ == Phase::asking_answer && data.size() >= 5 && data[0] == kModeAnswer) {
    if (are_capsules(data[4])) return enter(Phase::asking_period);
    express_ = false;  // capsules of another kind
    enter(Phase::asking_rate);
  } else if (phase_ == Phase::asking_period && data.size() >= 8 && data[0] == kModeSamplePeriod) {
    if (value(4) > 0) periods_.express_s = value(4) / 256.0 * 1e-6;  // an S3 has said 0
    enter(Phase::asking_range);
  } else if (phase_ == Phase::asking_range && data.size() >= 8 && data[0] == kModeMaxRange) {
    if (value(4) > 0) laser_.range_max_m = value(4) / 256.0;
    enter(Phase::starting);
  }
}

void RplidarDriver::stop() {
  stream_.write(encode_request(kStop));
  const bool by_speed = family_of(laser_.model) >= 6;
  stream_.write(by_speed ? motor_speed_request(0) : motor_request(0));
  stream_.set_dtr(true);
}

std::string RplidarDriver::state() const {
  std::string state =
      phase_ <= Phase::asking_info ? "looking for the laser" : "setting the laser up";
  if (phase_ == Phase::measuring) {
    state = std::string("measuring, ") + (express_ ? "express" : "standard") + ", " +
            describe_scans(counts(), scans_.filter()) +
            format(", %.1f a second", scans_.turn_s() > 0.0 ? 1.0 / scans_.turn_s() : 0.0);
  }
  if (laser_.model != 0) state += ", " + model_name(laser_.model);
  state += (answers() ? ", " : ", at ") + std::to_string(search_.current()) + " baud";
  return with_trouble(state, counts(), trouble_);
}

}  // namespace marco::drivers::rplidar
