// The mirror's half of the emulator: when its turns end and what they saw.
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/pose2.hpp"
#include "drivers/sick/emulator.hpp"

namespace marco::drivers::sick {
namespace {

// Of each beam; one that ever saw a code instead of a distance tells that.
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

}  // namespace

int SickEmulator::turns_per_scan() const { return partial_mode() ? 1 : 100 / resolution_cdeg_; }

void SickEmulator::schedule_turn(Utime not_before) {
  const double turns = (not_before - mirror_start_).seconds() / options_.turn_s;
  turn_end_ = static_cast<int64_t>(std::ceil(turns)) + turns_per_scan();
}

uint8_t SickEmulator::reflectivity_of(uint16_t word) const {
  // A grey wall's: it falls with the distance. The world knows no colours.
  const RangeRule rule = range_rule(configuration_.measuring_mode());
  if (special_of(word, rule)) return 0;
  const double range_m = (word & rule.distance_mask) * metres(configuration_.unit());
  return static_cast<uint8_t>(std::lround(250.0 / (1.0 + 0.1 * range_m)));
}

uint16_t SickEmulator::word_of_range(double range_m) const {
  const RangeRule rule = range_rule(configuration_.measuring_mode());
  if (std::isnan(range_m)) return word_of(Special::dazzled, rule);
  if (std::isinf(range_m)) return word_of(Special::no_echo, rule);
  const double units = std::max(0.0, range_m) / metres(configuration_.unit());
  if (units >= rule.first_special - 0.5) return word_of(Special::beyond_range, rule);
  return static_cast<uint16_t>(std::lround(units));
}

MeasuredValues SickEmulator::measure(Utime first_beam) const {
  const int turns = turns_per_scan();
  const int all_turns = 100 / resolution_cdeg_;
  MeasuredValues values;
  values.unit = configuration_.unit();
  int first_offset = 0;
  if (partial_mode()) {
    const auto turn = static_cast<int64_t>(
        std::llround((first_beam - mirror_start_).seconds() / options_.turn_s));
    first_offset = static_cast<int>(turn % all_turns);
    values.partial = true;
    values.partial_offset_quarters = first_offset * resolution_cdeg_ / 25;
  }
  const int whole = angle_deg_ + (turns > 1 || first_offset == 0 ? 1 : 0);
  values.words.resize(turns > 1 ? static_cast<std::size_t>(angle_deg_ * turns + 1)
                                : static_cast<std::size_t>(whole));
  for (int turn = 0; turn < turns; ++turn) {
    const int offset = first_offset + turn;
    LaserSweep sweep;
    sweep.first_beam =
        first_beam + Duration::from_seconds(turn * options_.turn_s +
                                            offset * resolution_cdeg_ / 36000.0 * options_.turn_s);
    sweep.beam_interval_s = options_.turn_s / 360.0;
    sweep.first_bearing_rad = deg_to_rad(-0.5 * angle_deg_ + offset * resolution_cdeg_ * 0.01);
    sweep.bearing_step_rad = deg_to_rad(1.0);
    sweep.beams = angle_deg_ + (offset == 0 ? 1 : 0);
    const std::vector<double> ranges_m = world_(sweep);
    for (std::size_t i = 0; i < ranges_m.size() && i < static_cast<std::size_t>(sweep.beams); ++i) {
      values.words[i * static_cast<std::size_t>(turns) + static_cast<std::size_t>(turn)] =
          word_of_range(ranges_m[i]);
    }
  }
  return values;
}

Utime SickEmulator::turn_end_time() const {
  return mirror_start_ + Duration::from_seconds(static_cast<double>(turn_end_) * options_.turn_s);
}

void SickEmulator::finish_turn() {
  const int turns = turns_per_scan();
  const Utime end = turn_end_time();
  const Utime first_beam = end - Duration::from_seconds(turns * options_.turn_s);
  MeasuredValues values = measure(first_beam);
  turn_end_ += turns;
  if (form_ == kMean || form_ == kMeanSubRange) {
    summed_.push_back(std::move(values.words));
    if (summed_.size() < samples_) return;
    values.words = mean_of(std::exchange(summed_, {}), range_rule(configuration_.measuring_mode()));
    values.samples = samples_;
  }
  if (form_ == kSubRange || form_ == kMeanSubRange || form_ == kReflectivity) {
    values.sub_range = sub_range_;
    const std::vector<uint16_t> part(values.words.begin() + sub_range_[0] - 1,
                                     values.words.begin() + sub_range_[1]);
    if (form_ == kReflectivity) {
      for (const uint16_t word : part) values.reflectivity.push_back(reflectivity_of(word));
    } else {
      values.words = part;
    }
  }
  if ((configuration_.availability() & 2) != 0) {
    const auto index = static_cast<uint8_t>(scans_sent_);
    values.indices = {static_cast<uint8_t>(turn_end_), index};
  }
  const auto status = static_cast<uint8_t>(kHealthy | (options_.polluted ? 0x80 : 0));
  output_.send(encode_reply(encode_values(values), status, static_cast<uint8_t>(options_.address)),
               end);
  ++scans_sent_;
  last_values_ = std::move(values);
  last_first_beam_ = first_beam;
  one_scan_asked_ = false;
  // Scans that end while the line is taken are never sent.
  const int64_t was = turn_end_;
  while (turn_end_time() < output_.free_at()) turn_end_ += turns;
  scans_dropped_ += (turn_end_ - was) / turns;
}

}  // namespace marco::drivers::sick
