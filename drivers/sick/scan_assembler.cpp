#include "drivers/sick/scan_assembler.hpp"

#include "common/pose2.hpp"
#include "drivers/laser/beam_order.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::sick {

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

}  // namespace marco::drivers::sick
