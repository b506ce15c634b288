#include "simulator/devices/sick/mirror.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/pose2.hpp"

namespace marco::drivers::sick {
namespace {

// The mean of each beam. A beam that was a code in any scan becomes that code.
std::vector<uint16_t> mean_of(const std::vector<std::vector<uint16_t>>& scans,
                              const RangeRule& rule) {
  std::vector<uint16_t> mean = scans.front();
  for (std::size_t i = 0; i < mean.size(); ++i) {
    unsigned sum = 0;
    std::optional<uint16_t> code;
    for (const std::vector<uint16_t>& words : scans) {
      if (!code && special_of(words[i], rule)) code = words[i];
      sum += words[i] & rule.distance_mask;
    }
    const auto count = static_cast<unsigned>(scans.size());
    mean[i] = code ? *code : static_cast<uint16_t>((sum + count / 2) / count);
  }
  return mean;
}

// A grey wall's: it falls with the distance. The world has no colours.
uint8_t reflectivity_of(uint16_t word, const Configuration& configuration) {
  const RangeRule rule = range_rule(configuration.measuring_mode());
  if (special_of(word, rule)) return 0;
  const double range_m = (word & rule.distance_mask) * metres(configuration.unit());
  return static_cast<uint8_t>(std::lround(250.0 / (1.0 + 0.1 * range_m)));
}

uint16_t word_of_range(double range_m, const Configuration& configuration) {
  const RangeRule rule = range_rule(configuration.measuring_mode());
  if (std::isnan(range_m)) return word_of(Special::dazzled, rule);
  if (std::isinf(range_m)) return word_of(Special::no_echo, rule);
  const double units = std::max(0.0, range_m) / metres(configuration.unit());
  if (units >= rule.first_special - 0.5) return word_of(Special::beyond_range, rule);
  return static_cast<uint16_t>(std::lround(units));
}

}  // namespace

int SickMirror::turns_per_scan() const {
  return form_.mode == kPartialScans ? 1 : 100 / variant_.resolution_cdeg;
}

void SickMirror::begin(const Form& form, Utime not_before) {
  form_ = form;
  summed_.clear();
  const double turns = (not_before - start_).seconds() / turn_s_;
  turn_end_ = static_cast<int64_t>(std::ceil(turns)) + turns_per_scan();
}

Utime SickMirror::scan_end() const {
  return start_ + Duration::from_seconds(static_cast<double>(turn_end_) * turn_s_);
}

MeasuredValues SickMirror::measure(Utime first_beam, const Configuration& configuration) const {
  const int turns = turns_per_scan();
  const int angle_deg = variant_.angle_deg, resolution_cdeg = variant_.resolution_cdeg;
  MeasuredValues values;
  values.unit = configuration.unit();
  int first_offset = 0;
  if (form_.mode == kPartialScans) {
    const auto turn = static_cast<int64_t>(std::llround((first_beam - start_).seconds() / turn_s_));
    first_offset = static_cast<int>(turn % (100 / resolution_cdeg));
    values.partial = true;
    values.partial_offset_quarters = first_offset * resolution_cdeg / 25;
  }
  const int whole = angle_deg + (turns > 1 || first_offset == 0 ? 1 : 0);
  values.words.resize(static_cast<std::size_t>(turns > 1 ? angle_deg * turns + 1 : whole));
  for (int turn = 0; turn < turns; ++turn) {
    const int offset = first_offset + turn;
    LaserSweep sweep;
    sweep.first_beam =
        first_beam +
        Duration::from_seconds(turn * turn_s_ + offset * resolution_cdeg / 36000.0 * turn_s_);
    sweep.beam_interval_s = turn_s_ / 360.0;
    sweep.first_bearing_rad = deg_to_rad(-0.5 * angle_deg + offset * resolution_cdeg * 0.01);
    sweep.bearing_step_rad = deg_to_rad(1.0);
    sweep.beams = angle_deg + (offset == 0 ? 1 : 0);
    const std::vector<double> ranges_m = world_(sweep);
    for (std::size_t i = 0; i < ranges_m.size() && i < static_cast<std::size_t>(sweep.beams); ++i) {
      values.words[i * static_cast<std::size_t>(turns) + static_cast<std::size_t>(turn)] =
          word_of_range(ranges_m[i], configuration);
    }
  }
  return values;
}

std::optional<MeasuredValues> SickMirror::finish_scan(const Configuration& configuration) {
  const int turns = turns_per_scan();
  last_first_beam_ = scan_end() - Duration::from_seconds(turns * turn_s_);
  MeasuredValues values = measure(last_first_beam_, configuration);
  turn_end_ += turns;
  if (form_.mode == kMean || form_.mode == kMeanSubRange) {
    summed_.push_back(std::move(values.words));
    if (summed_.size() < form_.samples) return std::nullopt;
    values.words = mean_of(std::exchange(summed_, {}), range_rule(configuration.measuring_mode()));
    values.samples = form_.samples;
  }
  const bool reflectivity = form_.mode == kReflectivity;
  if (reflectivity || form_.mode == kSubRange || form_.mode == kMeanSubRange) {
    values.sub_range = form_.sub_range;
    const std::vector<uint16_t> part(values.words.begin() + form_.sub_range[0] - 1,
                                     values.words.begin() + form_.sub_range[1]);
    if (!reflectivity) values.words = part;
    for (std::size_t i = 0; reflectivity && i < part.size(); ++i) {
      values.reflectivity.push_back(reflectivity_of(part[i], configuration));
    }
  }
  return values;
}

int64_t SickMirror::skip_until(Utime free_at) {
  const int64_t was = turn_end_;
  while (scan_end() < free_at) turn_end_ += turns_per_scan();
  return (turn_end_ - was) / turns_per_scan();
}

}  // namespace marco::drivers::sick
