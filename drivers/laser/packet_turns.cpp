#include "drivers/laser/packet_turns.hpp"

#include <cmath>

namespace marco::drivers {
namespace {

// Angles are rounded and speeds change a little: fewer missing samples are none, unless bytes are
// known to be lost.
constexpr double kLostFrom = 2.5, kKnownLostFrom = 0.5;
// From this part of a turn on, a gap may have been a turn longer than the angles show.
constexpr double kTurnAtMost = 0.8;
// A turn that misses more is not worth a scan.
constexpr double kLargestGapDeg = 90.0;
constexpr std::size_t kSamplesOfAStep = 8;

double turned_deg(double from_deg, double to_deg) {
  const double turned = std::fmod(to_deg - from_deg, 360.0);
  return turned < 0.0 ? turned + 360.0 : turned;
}

/// 0 of a packet so short that the rounding of its angles shows.
double step_of(const SamplePacket& packet) {
  const auto& samples = packet.samples;
  if (samples.size() < kSamplesOfAStep) return 0.0;
  return turned_deg(samples.front().angle_deg, samples.back().angle_deg) /
         static_cast<double>(samples.size() - 1);
}

}  // namespace

int64_t PacketTurns::lost_samples(const SamplePacket& packet, double step_deg) const {
  if (step_deg <= 0.0) return 0;
  const double gap_deg = turned_deg(last_->angle_deg, packet.samples.front().angle_deg);
  const double lost = gap_deg / step_deg - 1.0;
  // The angle may go back by a hair: by a few steps it is no gap of a whole turn.
  const bool back = 360.0 - gap_deg < kLostFrom * step_deg;
  return lost < (packet.continuous ? kLostFrom : kKnownLostFrom) || back ? 0 : std::llround(lost);
}

void PacketTurns::Learning::add(double x, double y) {
  packets += 1.0;
  sum_x += x;
  sum_y += y;
  sum_xx += x * x;
  sum_xy += x * y;
}

double PacketTurns::Learning::slope() const {
  return (packets * sum_xy - sum_x * sum_y) / (packets * sum_xx - sum_x * sum_x);
}

// Stamps are rounded and arrivals jitter: a line through all of them is surer than the ends.
void PacketTurns::learn(const SamplePacket& packet, bool gapless) {
  if (!learning_ || !gapless) {
    learning_ = Learning{packet.clock_s};
    learning_->add(0.0, 0.0);
    return;
  }
  learning_->samples += static_cast<double>(packet.samples.size());
  if (packet.samples.size() < 2) return;  // it waited for the packet before it
  const double since_s = packet.clock_s - learning_->since_s;
  learning_->add(learning_->samples, since_s);
  if (since_s < timing_.learn_s || learning_->slope() <= 0.0) return;
  clock_.start(learning_->slope());
  learned_ = true;
}

void PacketTurns::mind_gap(const SamplePacket& packet, double step_deg, int64_t lost) {
  const bool may_miss = lost > 0 || !packet.continuous || timing_.laser_has_clock;
  const double turn_s = 360.0 / step_deg * clock_.sample_s();
  if (may_miss && std::abs(packet.clock_s - last_->clock_s) > kTurnAtMost * turn_s) {
    ++counts_.drops["lost_turn"];
    return lose_count();
  }
  if (lost == 0) return;
  ++counts_.drops["lost_samples"];
  clock_.skip(lost);
  if (static_cast<double>(lost) * step_deg > kLargestGapDeg) gatherer_.drop_turn();
}

void PacketTurns::gather(const SamplePacket& packet) {
  for (const SamplePacket::Sample& sample : packet.samples) {
    const bool new_turn = last_ && sample.angle_deg < last_->angle_deg - 180.0;
    if (new_turn && gatherer_.begin_turn(packet.arrival)) ++counts_.scans;
    gatherer_.add({clock_.count(), sample.bearing_rad, sample.range_m, sample.intensity});
    if (last_) last_->angle_deg = sample.angle_deg;
  }
  clock_.note_arrival(packet.left);
}

void PacketTurns::add(const SamplePacket& packet) {
  if (packet.samples.empty()) return;
  const double own_step_deg = step_of(packet);
  const double step_deg = own_step_deg > 0.0 ? own_step_deg : last_ ? last_->step_deg : 0.0;
  const int64_t lost = last_ ? lost_samples(packet, step_deg) : 0;
  if (!learned_) learn(packet, last_ && lost == 0 && packet.continuous);
  // A packet by which the period became known is the first to be counted.
  if (learned_) {
    if (last_ && step_deg > 0.0) mind_gap(packet, step_deg, lost);
    gather(packet);
  }
  last_ = Last{packet.samples.back().angle_deg, step_deg, packet.clock_s};
  // Learned while the host stood still, or the laser changed its rate.
  if (std::abs(clock_.filter().drift()) > 0.9 * kMaxDrift) restart();
}

void PacketTurns::lose_count() {
  clock_.lose_count();
  gatherer_.drop_turn();
  learning_.reset();
  last_.reset();
}

void PacketTurns::restart() {
  lose_count();
  learned_ = false;
}

}  // namespace marco::drivers
