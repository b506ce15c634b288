#include "simulator/logger_model.hpp"

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"

namespace marco::sim {

LoggerModel::LoggerModel(const LoggerOptions& options, const LaserOptions& laser)
    : options_(options), laser_(laser), beam_times_(named(options.beam_times)) {
  validate(options, "logger");
}

LoggerModel::BeamTimes LoggerModel::named(const std::string& name) {
  if (name == "right") return BeamTimes::right;
  if (name == "milliseconds") return BeamTimes::milliseconds;
  if (name == "reversed") return BeamTimes::reversed;
  if (name == "equal") return BeamTimes::equal;
  require(name == "missing", "logger.beam_times '" + name +
                                 "': expected right, milliseconds, reversed, equal or missing");
  return BeamTimes::missing;
}

double LoggerModel::measured_s(double said_s) const {
  return beam_times_ == BeamTimes::reversed ? laser_.scan_duration_s - said_s : said_s;
}

double LoggerModel::told_duration_s() const {
  return beam_times_ == BeamTimes::right ? laser_.scan_duration_s : 0.0;
}

std::optional<Utime> LoggerModel::stamp(Utime start, double began_s, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 1.0);
  if (options_.dropped_scans > 0.0 && uniform(random) < options_.dropped_scans) return {};
  Utime stamp = start + Duration::from_seconds((1.0 + options_.clock_drift) * began_s +
                                               options_.stamp_late_s);
  if (options_.stamp_jitter_s > 0.0) {
    stamp = stamp + Duration::from_seconds(options_.stamp_jitter_s * noise(random));
  }
  if (options_.burst_part > 0.0 && uniform(random) < options_.burst_part) {
    stamp = last_stamp_.value_or(start) + Duration::from_us(1000);
  }
  last_stamp_ = stamp;
  return stamp;
}

float LoggerModel::told_offset_s(int beam) const {
  constexpr double kMicrosecondsInAMillisecond = 1000.0;
  const double offset_s = (1.0 + options_.clock_drift) * laser_.time_of_beam_s(beam);
  if (beam_times_ == BeamTimes::equal) return 0.0F;
  if (beam_times_ == BeamTimes::milliseconds) {
    return static_cast<float>(offset_s / kMicrosecondsInAMillisecond);
  }
  return static_cast<float>(offset_s);
}

std::vector<LaserScan> LoggerModel::messages(const LaserScan& scan) const {
  if (beam_times_ == BeamTimes::missing) return {scan};
  LaserScan raw = scan;
  raw.channel = channels::kLidarRaw;
  for (int beam = 0; beam < laser_.beams; ++beam) raw.time_offsets_s.push_back(told_offset_s(beam));
  if (beam_times_ == BeamTimes::right) return {raw, scan};
  return {raw};
}

}  // namespace marco::sim
