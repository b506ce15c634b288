// The driver's second half: from value telegrams to scans.
#include <cmath>
#include <cstdio>
#include <utility>

#include "drivers/sick/driver.hpp"
#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::sick {
namespace {

constexpr double kTurnS = 1.0 / 75.0;

}  // namespace

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
  const Duration on_line = line_time(event.bytes_total, baud_);
  const Utime end = arrival - on_line;
  const Utime filtered = filter_.update(turns_.update(end, gap_before()), end);
  ready_.push_back(to_scan(*values, filtered - Duration::from_seconds(scan_period_s()), arrival));
}

// What was heard, but damaged.
TurnCounter::Gap SickDriver::gap_before() {
  int64_t dropped = 0;
  for (const auto& [cause, count] : counts_.drops) dropped += count;
  const bool lost = std::exchange(dropped_before_, dropped) != dropped;
  return lost ? TurnCounter::Gap::any : TurnCounter::Gap::none;
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
  scan.first_bearing_rad = deg_to_rad(-0.5 * options_.angle_deg + offset_deg);
  scan.bearing_step_rad = deg_to_rad(step_deg);
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
