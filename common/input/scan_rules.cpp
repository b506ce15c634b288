#include "common/input/scan_rules.hpp"

#include <cmath>
#include <cstring>

#include "common/input/beam_times.hpp"

namespace marco {
namespace scan_rules {
namespace {

// Five scans of the slowest laser, 5 Hz.
constexpr double kRawEndedS = 1.0;
// Both messages of one scan carry its stamp, perhaps rounded to milliseconds.
constexpr double kSameScanS = 0.002;

bool is_within(const std::optional<Utime>& a, Utime b, double limit_s) {
  return a && std::abs((*a - b).seconds()) <= limit_s;
}

}  // namespace

bool Announced::apply(const WaitingScan& in, const RuleContext& context) const {
  if (context.info == nullptr) context.report("no SENSOR_INFO for " + in.scan.channel + " yet");
  return context.info != nullptr;
}

bool NotRepeated::apply(const WaitingScan& in, const RuleContext& context) {
  const LaserScan& scan = in.scan;
  LaserScan& before = last[scan.channel];
  // By its bits: a beam without a return may be NaN.
  const bool same = scan.utime == before.utime && !scan.ranges_m.empty() &&
                    scan.ranges_m.size() == before.ranges_m.size() &&
                    std::memcmp(scan.ranges_m.data(), before.ranges_m.data(),
                                scan.ranges_m.size() * sizeof(float)) == 0;
  if (same) {
    context.report("duplicate scan");
  } else {
    before = scan;
  }
  return !same;
}

bool OneChannelOfTwo::apply(const WaitingScan& in, const RuleContext& context) {
  const Utime stamp = in.scan.utime;
  Laser& laser = lasers[context.lidar];
  if (context.lidar != in.scan.channel) {
    laser.newest_raw = stamp;
    return !is_within(laser.newest_planar, stamp, kSameScanS);
  }
  if (is_within(laser.newest_raw, stamp, kRawEndedS)) return false;
  laser.newest_planar = stamp;
  return true;
}

bool OneSender::apply(const WaitingScan& in, const RuleContext& context) {
  if (rates.is_new_sender(in.scan.channel, in.scan.utime)) context.report(rates.notice());
  return true;
}

bool RangesInMetres::apply(const WaitingScan& in, const RuleContext& context) {
  const auto wrong = units.look(in.scan);
  if (wrong) context.report(fault = *wrong);
  return !wrong;
}

bool BeamsCalibrated::apply(WaitingScan& in, const RuleContext& context) const {
  for (const BeamCalibration& beams : context.calibration.beams) {
    if (beams.channel == in.scan.channel) beams.correct(in.scan, context.info->range_max_m);
  }
  return true;
}

std::size_t WithoutKnownBody::blank(LaserScan& scan, const RuleContext& context) const {
  std::size_t blanked = 0;
  for (const BodyPart& part : context.calibration.body) {
    if (part.channel == scan.channel) blanked += marco::blank(scan, part);
  }
  return blanked;
}

std::size_t WithoutFloor::blank(LaserScan& scan, const RuleContext& context) const {
  std::size_t blanked = 0;
  for (const FloorLine& floor : context.calibration.floor) {
    if (floor.channel == scan.channel) blanked += marco::blank(scan, floor);
  }
  return blanked;
}

std::size_t WithoutOwnBody::blank(LaserScan& scan, const RuleContext& context) {
  if (context.info->mount != SensorInfo::Mount::robot) return 0;
  OwnBody& body = bodies[scan.channel];
  const bool was_known = !body.parts().empty();
  if (body.look(scan) && !was_known && !body.parts().empty()) {
    context.report(describe(body.parts()) + ": these returns are ignored");
  }
  std::size_t blanked = 0;
  for (const BodyPart& part : body.parts()) blanked += marco::blank(scan, part);
  return blanked;
}

bool StampRepaired::apply(WaitingScan& in, const RuleContext&) {
  StampRepair& stamps = lasers[in.scan.channel];
  in.repaired = stamps.repair(in.scan.utime);
  in.period_s = stamps.period_s();
  in.off_beat = stamps.off_beat();
  return true;
}

bool BeamTimesRepaired::apply(WaitingScan& in, const RuleContext& context) {
  const auto wrong = repair_beam_times(in.scan, in.period_s);
  if (wrong && reported.insert(in.scan.channel).second) {
    context.report(in.scan.channel + ": " + *wrong);
  }
  return true;
}

bool BeamsOrdered::apply(WaitingScan& in, const RuleContext& context) {
  if (in.scan.time_offsets_s.empty() && is_turn_period(context.info->scan_duration_s)) return true;
  in.beam_order = judges[in.scan.channel].look(in.scan, in.period_s);
  return true;
}

}  // namespace scan_rules

template <class Rule>
bool ScanRules::Counted<Rule>::apply(WaitingScan& in, const RuleContext& context) {
  if constexpr (requires { rule.blank(in.scan, context); }) {
    count.returns += static_cast<int64_t>(rule.blank(in.scan, context));
    return true;
  } else {
    const bool is_used = rule.apply(in, context);
    count.scans += is_used ? 0 : 1;
    return is_used;
  }
}

bool ScanRules::apply(WaitingScan& in, const RuleContext& context) {
  return std::apply([&](auto&... rules) { return (rules.apply(in, context) && ...); }, rules_);
}

std::vector<std::pair<std::string, RuleCount>> ScanRules::counts() const {
  std::vector<std::pair<std::string, RuleCount>> counts;
  const auto add = [&]<class Rule>(const Counted<Rule>& counted) {
    counts.emplace_back(Rule::kName, counted.count);
  };
  std::apply([&](const auto&... rules) { (add(rules), ...); }, rules_);
  return counts;
}

}  // namespace marco
