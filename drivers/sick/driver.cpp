#include "drivers/sick/driver.hpp"

#include <algorithm>

#include "common/pose2.hpp"
#include "drivers/laser/beam_order.hpp"
#include "drivers/laser/laser_state.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::sick {
namespace {

using std::chrono::microseconds;
constexpr microseconds kStep{50'000};
constexpr Duration kSettle = Duration::from_us(250'000);
constexpr Duration kNakRest = Duration::from_us(30'000);  // before the request is repeated
constexpr Duration kDamagedRest = Duration::from_us(250'000);
constexpr Duration kStopPatience = Duration::from_us(500'000);
constexpr int kTries = 3;
constexpr std::size_t kLongestScanBytes = 2 * 401 + 12;

SickOptions checked(const SickOptions& options) {
  validate(options, "sick");
  require(mode_of_baud(options.baud).has_value(),
          "SICK baud is 9600, 19200, 38400 or 500000; not " + std::to_string(options.baud));
  require(options.password.size() == 8, "the laser's password has 8 characters");
  return options;
}

}  // namespace

ScanAssembler::ScanAssembler(const SickOptions& options)
    : options_(options),
      rule_(range_rule(options.measuring_mode())),
      clock_(options.scan_period_s()) {
  require(beams_of_variant(options.angle_deg, options.resolution_cdeg()) > 0,
          "the laser has no variant of " + std::to_string(options.angle_deg) + " deg by " +
              std::to_string(options.resolution_deg) +
              " deg: there are 180 by 1 or 0.5 deg, and 100 by 1, 0.5 or 0.25 deg");
}

LaserProperties ScanAssembler::properties() const {
  const double fan_s = options_.angle_deg / 360.0 * kTurnS;
  return {(options_.turns_per_scan() - 1) * kTurnS + fan_s, options_.range_min_m,
          rule_.first_special * metres(options_.value_unit()), options_.range_sigma_m};
}

const char* ScanAssembler::reason_to_drop(const Event& event,
                                          const std::optional<MeasuredValues>& values) const {
  if (!values) return "inconsistent";
  const auto beams = static_cast<int>(values->words.size());
  const bool is_turn = values->partial && options_.interlaced && beams >= options_.angle_deg;
  if (!is_turn && beams != beams_of_variant(options_.angle_deg, options_.resolution_cdeg())) {
    return "other_variant";
  }
  if (values->unit != options_.value_unit()) return "other_unit";
  return (event.status() & 7) == 4 ? "fatal_status" : nullptr;
}

void ScanAssembler::add(const Event& event, Utime arrival, int baud) {
  const auto values = decode_values(event);
  if (const char* reason = reason_to_drop(event, values)) {
    ++counts_.drops[reason];
    return;
  }
  ++counts_.scans;
  const Utime end = clock_.update(arrival - line_time(event.bytes_total, baud), counts_.dropped());
  const Utime first_beam = end - Duration::from_seconds(options_.scan_period_s());
  ready_.push_back({scan_of(*values, first_beam), arrival});
}

LaserScan ScanAssembler::scan_of(const MeasuredValues& values, Utime first_beam) const {
  const double metre = metres(values.unit);
  const auto beyond_m = static_cast<float>(rule_.first_special * metre);
  const double offset_deg = values.partial ? 0.25 * values.partial_offset_quarters : 0.0;
  const double step_deg = values.partial ? 1.0 : 0.01 * options_.resolution_cdeg();
  LaserScan scan;
  scan.utime = first_beam + Duration::from_seconds(offset_deg / 360.0 * kTurnS);
  scan.first_bearing_rad = deg_to_rad(-0.5 * options_.angle_deg + offset_deg);
  scan.bearing_step_rad = deg_to_rad(step_deg);
  scan.ranges_m.reserve(values.words.size());
  scan.time_offsets_s.reserve(values.words.size());
  for (std::size_t i = 0; i < values.words.size(); ++i) {
    const auto special = special_of(values.words[i], rule_);
    float range_m = static_cast<float>((values.words[i] & rule_.distance_mask) * metre);
    if (special) {
      const bool nothing_there = *special == Special::no_echo || *special == Special::beyond_range;
      range_m = nothing_there ? beyond_m : 0.0f;
    }
    scan.ranges_m.push_back(range_m);
    scan.time_offsets_s.push_back(static_cast<float>(
        beam_time_s(static_cast<int>(i), step_deg, options_.turns_per_scan(), kTurnS)));
  }
  return scan;
}

SickDriver::SickDriver(ByteStream& stream, const SickOptions& options, Clock clock)
    : clock_(clock),
      link_(stream, checked(options).baud, std::move(clock)),
      dialogue_(options),
      assembler_(options) {
  try_next_baud_rate();
}

void SickDriver::enter(Phase phase) {
  phase_ = phase;
  tries_ = 0;
  if (phase == Phase::measuring) {
    assembler_.restart_clock();
    trouble_ = dialogue_.defect() ? "the laser reports a defect" : "";
    deadline_ = clock_() + silence_allowed();
  } else if (phase == Phase::settling) {
    link_.use_goal_baud();
    deadline_ = clock_() + kSettle;
  } else {
    ask();
  }
}

void SickDriver::ask() {
  ++tries_;
  link_.send(dialogue_.request(phase_, link_.goal_baud()));
  deadline_ = clock_() + dialogue_.patience(phase_, link_.baud());
}

// A damaged reply is lost. Some replies may take seven seconds: no use in waiting for this one.
void SickDriver::ask_again_within(Duration rest) {
  if (phase_ == Phase::measuring || phase_ == Phase::settling) return;
  deadline_ = std::min(deadline_, clock_() + rest);
}

void SickDriver::try_next_baud_rate() {
  const std::string why_not = link_.try_next_baud_rate();
  if (!why_not.empty()) trouble_ = why_not;
  streams_here_ = acknowledged_ = false;
  enter(Phase::finding);
}

void SickDriver::start_over(const std::string& why) {
  trouble_ = why;
  link_.restart_search();
  try_next_baud_rate();
}

Duration SickDriver::silence_allowed() const {
  const double scan_s =
      std::max(assembler_.period_s(), line_time(kLongestScanBytes, link_.baud()).seconds());
  return Duration::from_seconds(0.3 + 3.0 * scan_s);
}

std::vector<ArrivedScan> SickDriver::step() {
  receive();
  if (phase_ == Phase::measuring) {
    if (clock_() > deadline_) start_over("the scans stopped");
  } else if (clock_() >= deadline_) {
    on_timeout();
  }
  assembler_.counts().garbage_bytes = link_.garbage_bytes();
  return assembler_.take_scans();
}

void SickDriver::on_input_flushed() {
  link_.flush();
  assembler_.restart_clock();
  if (phase_ == Phase::measuring) deadline_ = clock_() + silence_allowed();
}

void SickDriver::receive() {
  microseconds wait = kStep;
  if (phase_ != Phase::measuring) {
    wait = std::clamp(microseconds((deadline_ - clock_()).us), microseconds(0), kStep);
  }
  const SickLink::Received received = link_.receive(wait);
  if (received.gap) ask_again_within(kDamagedRest);
  while (const auto event = link_.next()) on_event(*event, received.arrival);
}

void SickDriver::on_event(const Event& event, Utime arrival) {
  if (event.kind == Event::Kind::bad_checksum) {
    if (phase_ == Phase::measuring) ++assembler_.counts().drops["bad_checksum"];
    return ask_again_within(kDamagedRest);
  }
  if (event.kind == Event::Kind::ack) {
    // The laser listens at this speed. A change of mode may take it three seconds.
    if (phase_ == Phase::finding && link_.garbage_bytes() == counts().garbage_bytes) {
      acknowledged_ = true;
      deadline_ = std::max(deadline_, clock_() + Dialogue::kModePatience);
    }
    return;
  }
  if (event.kind == Event::Kind::nak) return ask_again_within(kNakRest);
  status_ = event.status();
  if (event.code() == kPowerOnReply) {
    dialogue_.note_type(event.data());
    if (phase_ == Phase::finding) return ask();
    start_over("the laser was reset");
  } else if (event.code() == kValuesReply && phase_ == Phase::measuring) {
    const int64_t scans = counts().scans;
    const Utime last_byte = arrival - line_time(event.bytes_after, link_.baud());
    assembler_.add(event, last_byte, link_.baud());
    if (counts().scans > scans) deadline_ = last_byte + silence_allowed();
  } else if (phase_ != Phase::measuring && phase_ != Phase::settling) {
    on_reply(event);
  }
}

void SickDriver::on_reply(const Event& event) {
  if (phase_ == Phase::finding && event.code() == kValuesReply) {
    // It streams at this speed. The request to stop is repeated if it was lost.
    if (!std::exchange(streams_here_, true)) deadline_ = clock_() + kStopPatience;
    return;
  }
  switch (dialogue_.read(phase_, event)) {
    case Dialogue::Answer::other:
      return;
    case Dialogue::Answer::refused:
      return start_over(phase_ == Phase::entering_installation ? "the laser refused the password"
                                                               : "the laser refused a command");
    case Dialogue::Answer::accepted:
      return enter(dialogue_.next(phase_, link_.baud() == link_.goal_baud()));
  }
}

void SickDriver::on_timeout() {
  if (phase_ == Phase::settling) return enter(dialogue_.next(phase_, true));
  if (phase_ == Phase::finding) {
    const bool streams = std::exchange(streams_here_, false);
    const bool acknowledged = std::exchange(acknowledged_, false);
    return streams || acknowledged ? ask() : try_next_baud_rate();
  }
  // Perhaps only the reply was lost, and the laser has changed its speed already.
  if (phase_ == Phase::changing_baud) return start_over("no answer to the change of speed");
  if (tries_ < kTries) return ask();
  if (phase_ == Phase::checking_baud) {
    const std::string wanted = std::to_string(link_.goal_baud());
    if (link_.fall_back()) {
      return start_over("no answer at " + wanted + " baud: stays at 9600");
    }
  }
  start_over("the laser stopped answering");
}

void SickDriver::stop() { link_.send(set_mode_request(kOnRequest)); }

std::string SickDriver::state() const {
  std::string state;
  if (phase_ == Phase::measuring) {
    const std::string complaint = describe_status_byte(status_);
    state = "measuring at " + std::to_string(link_.baud()) + " baud" +
            (complaint.empty() ? "" : " with " + complaint) + ", " +
            describe_scans(counts(), assembler_.filter());
  } else if (phase_ == Phase::finding) {
    state = "looking for the laser, at " + std::to_string(link_.baud()) + " baud";
  } else {
    state = "setting the laser up, step " + std::to_string(static_cast<int>(phase_));
  }
  if (!dialogue_.type().empty()) state += ", " + dialogue_.type();
  return with_trouble(state, counts(), trouble_);
}

}  // namespace marco::drivers::sick
