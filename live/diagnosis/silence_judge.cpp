#include "live/diagnosis/silence_judge.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lcm_tools/base/format.hpp"
#include "lcm_tools/schema/schema.hpp"
#include "lcmtypes/channels.hpp"
#include "live/diagnosis/bus_survey.hpp"
#include "marco/sensor_info_t.hpp"

namespace marco::diagnosis {
namespace {

constexpr double kBusyS = 0.5;   // longer between two steps: the program was not listening
constexpr double kComesS = 3.0;  // a message within it: the channel is alive
constexpr int kDisagreements = 5;
constexpr int kReturns = 3;  // a restarted driver may announce another pose once
constexpr std::size_t kSensors = 100, kChannels = 100;  // remembered

std::string pose_of(const sensor_info_t& info) {
  const double* at = info.parent_from_sensor_m;
  const double* turned = info.parent_from_sensor_quat;
  return format("%d: %.3f %.3f %.3f m, %.3f %.3f %.3f %.3f", info.mount, at[0], at[1], at[2],
                turned[0], turned[1], turned[2], turned[3]);
}

}  // namespace

SilenceJudge::SilenceJudge(std::vector<Expectation> expectations, const process::DropCounter* drops)
    : drops_(drops) {
  for (Expectation& expected : expectations) {
    ChannelPattern pattern(expected.pattern);
    tracks_.push_back({std::move(expected), std::move(pattern), {}, {}, {}, {}});
  }
}

// Sees whether the program used or dropped the last message.
void SilenceJudge::settle() {
  Track* const handled = std::exchange(handled_, nullptr);
  if (drops_ == nullptr) return;
  const int64_t dropped = drops_->dropped();
  if (dropped == dropped_before_) {
    if (handled != nullptr) handled->dropped.count = 0;
    return;
  }
  dropped_before_ = dropped;
  std::string cause;
  for (const auto& [name, count] : drops_->by_cause()) {
    if (std::exchange(drops_before_[name], count) < count) cause = name;
  }
  // Handlers of other channels use, and drop, scans that waited for them.
  if (handled != &tracks_.front()) return;
  // Not faults: the program was paused, or the laser nods.
  if (cause == "paused" || cause == "tilted") {
    handled->dropped.count = 0;
    return;
  }
  if (handled->dropped.count++ == 0) handled->dropped.first_s = time_s_;
  handled->dropped.cause = cause;
}

void SilenceJudge::heard(const process::RawMessage& raw) {
  settle();
  if (raw.channel == channels::kSensorInfo) watch_pose(raw);
  const std::vector<std::size_t>& expecting = expecting_tracks(std::string(raw.channel));
  if (expecting.empty()) return;
  const std::string type = type_name(lcm_schema::fingerprint_of(raw.bytes).value_or(0));
  for (const std::size_t i : expecting) count(tracks_[i], raw, type);
}

const std::vector<std::size_t>& SilenceJudge::expecting_tracks(const std::string& channel) {
  const auto known = tracks_of_channel_.find(channel);
  if (known != tracks_of_channel_.end()) return known->second;
  if (tracks_of_channel_.size() >= kChannels) tracks_of_channel_.clear();
  std::vector<std::size_t>& expecting = tracks_of_channel_[channel];
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (tracks_[i].pattern.matches(channel)) expecting.push_back(i);
  }
  return expecting;
}

void SilenceJudge::count(Track& track, const process::RawMessage& raw, const std::string& type) {
  const auto& types = track.expected.types;
  if (std::find(types.begin(), types.end(), type) == types.end()) {
    if (track.wrong.count++ == 0) track.wrong.first_s = time_s_;
    track.wrong.last_s = time_s_;
    track.wrong.channel = raw.channel;
    track.wrong.fingerprint = lcm_schema::fingerprint_of(raw.bytes).value_or(0);
    return;
  }
  if (track.expected.counts && !track.expected.counts(raw)) return;
  if (time_s_ - track.coming.last_s > kEndedS)
    track.coming.count = 0;  // a new stretch, with a rate of its own
  if (track.coming.count++ == 0) track.coming.first_s = time_s_;
  track.coming.last_s = time_s_;
  track.wrong.count = 0;
  track.coming.channel = raw.channel;
  track.coming.stamp_us = stamp_at_head(raw.bytes);
  if (&track == &tracks_.front()) compare_clocks();
  handled_ = &track;
}

void SilenceJudge::watch_pose(const process::RawMessage& raw) {
  sensor_info_t info;
  if (info.decode(raw.bytes.data(), 0, static_cast<int>(raw.bytes.size())) < 0) return;
  if (places_.size() >= kSensors && !places_.contains(info.channel)) return;
  Place& place = places_[info.channel];
  std::string pose = pose_of(info);
  if (pose == place.pose) return;
  if (pose == place.before) ++place.returns;
  place.before = std::exchange(place.pose, std::move(pose));
}

bool SilenceJudge::comes(const Track& track) const {
  const Coming& coming = track.coming;
  return coming.count > 0 &&
         time_s_ - coming.last_s < std::max(kComesS, kEndedPeriods * coming.period_s());
}

// Called when a message of the first expectation comes: SLAM pairs messages of the same time.
void SilenceJudge::compare_clocks() {
  const Track& first = tracks_.front();
  for (Track& track : tracks_) {
    const bool both = comes(track) && first.coming.stamp_us && track.coming.stamp_us;
    track.clock.ahead_s =
        both ? static_cast<double>(*track.coming.stamp_us - *first.coming.stamp_us) * 1e-6 : 0.0;
    const bool agree = std::abs(track.clock.ahead_s) < kClockS;
    track.clock.disagreements = agree ? 0 : track.clock.disagreements + 1;
    if (agree) track.clock.agreed_s = time_s_;
  }
}

void SilenceJudge::advance(double now_s) {
  settle();
  const double step_s = now_s - clock_s_.value_or(now_s);
  clock_s_ = now_s;
  time_s_ += std::clamp(step_s, 0.0, kBusyS);
}

std::optional<Lack> SilenceJudge::lack_of(const Track& track, double ahead_s) const {
  Lack lack;
  lack.expected = track.expected;
  lack.channel = track.coming.channel;
  lack.hz = track.coming.hz();
  const bool needed = track.expected.without.empty();
  const double now_s = time_s_ + ahead_s;
  lack.silent_s = now_s - (track.coming.count > 0 ? track.coming.last_s : 0.0);
  if (track.wrong.count > 1 && track.wrong.last_s - track.wrong.first_s >= kNeverS - ahead_s &&
      time_s_ - track.wrong.last_s < kComesS) {
    lack.kind = Lack::Kind::wrong_type;
    lack.channel = track.wrong.channel;
    lack.fingerprint = track.wrong.fingerprint;
    lack.hz = static_cast<double>(track.wrong.count - 1) /
              (track.wrong.last_s - track.wrong.first_s + 1e-3);
    return lack;
  }
  if (track.coming.count == 0) {
    lack.kind = Lack::Kind::never;
    return lack.silent_s >= (needed ? kNeverS : kWithoutS) ? std::optional(lack) : std::nullopt;
  }
  if (lack.silent_s >= std::max(kEndedS, kEndedPeriods * track.coming.period_s())) {
    lack.kind = Lack::Kind::ended;
    return lack;
  }
  if (track.dropped.count > 2 && now_s - track.dropped.first_s >= kNeverS) {
    lack.kind = Lack::Kind::unused;
    lack.cause = track.dropped.cause;
    lack.dropped = track.dropped.count;
    return lack;
  }
  if (now_s - track.clock.agreed_s >= kNeverS && track.clock.disagreements >= kDisagreements) {
    lack.kind = Lack::Kind::clock;
    lack.ahead_s = track.clock.ahead_s;
    return lack;
  }
  return std::nullopt;
}

std::vector<Lack> SilenceJudge::lacks(double ahead_s) const {
  std::vector<Lack> result;
  for (const Track& track : tracks_) {
    const bool needed = track.expected.without.empty();
    if (!needed && !result.empty()) continue;
    if (!needed && !comes(tracks_.front())) continue;
    if (auto lack = lack_of(track, ahead_s)) result.push_back(std::move(*lack));
  }
  for (const auto& [sensor, place] : places_) {
    if (place.returns < kReturns) continue;
    Lack lack;
    lack.kind = Lack::Kind::two_poses;
    lack.channel = sensor;
    lack.cause = place.pose + " and " + place.before;
    result.push_back(std::move(lack));
  }
  return result;
}

std::string SilenceJudge::what_comes() const {
  std::string text;
  for (const Track& track : tracks_) {
    if (!comes(track)) continue;
    text += (text.empty() ? "" : ", ") + track.coming.channel +
            (track.coming.count > 1 ? format(" %.3g Hz", track.coming.hz()) : "");
  }
  return text;
}

}  // namespace marco::diagnosis
