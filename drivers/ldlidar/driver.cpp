#include "drivers/ldlidar/driver.hpp"

#include <utility>

#include "common/pose2.hpp"
#include "drivers/laser/laser_state.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers::ldlidar {
namespace {

constexpr Duration kListen = Duration::from_us(500'000);
constexpr Duration kSilence = Duration::from_us(500'000);
constexpr int kFastBaud = 921'600;  // of an STL27L
constexpr double kRangeMaxM = 12.0, kFastRangeMaxM = 25.0;
// A stamp counts whole milliseconds. So long, a line through them is good to a part in 3000.
constexpr double kLearnS = 0.3;

}  // namespace

LdlidarDriver::LdlidarDriver(ByteStream& stream, const LdlidarOptions& options, Clock clock)
    : Dialogue(stream, std::move(clock), PacketTurns::Timing{true, kLearnS}),
      options_(options),
      search_(230'400, {kFastBaud, 115'200}) {
  validate(options, "ldlidar");
  listen_at_next_speed();
}

LaserProperties LdlidarDriver::properties() const {
  const double model_max_m = search_.current() == kFastBaud ? kFastRangeMaxM : kRangeMaxM;
  return {scans_.turn_s(), options_.range_min_m,
          options_.range_max_m > 0.0 ? options_.range_max_m : model_max_m, options_.range_sigma_m};
}

void LdlidarDriver::listen_at_next_speed() {
  set_speed(search_.next());
  parser_.clear();
  scans_.restart();
  stamp_ms_.reset();
  wait(kListen);
}

// The laser may only have been switched off: its own speed is listened at once more.
void LdlidarDriver::on_timeout() {
  if (!std::exchange(heard_, false)) return listen_at_next_speed();
  trouble_ = "the packets stopped";
  scans_.lose_count();
  wait(kListen);
}

void LdlidarDriver::on_input_flushed() {
  scans_.lose_count();
  parser_.clear();
  wait(kSilence);
}

// A laser that was switched off and on again begins again: any stamp is later than the last one.
double LdlidarDriver::unwrapped_s(int stamp_ms) {
  const int since_ms = stamp_ms - stamp_ms_.value_or(stamp_ms);
  stamps_s_ += 1e-3 * (since_ms < 0 ? since_ms + kStampWrapMs : since_ms);
  stamp_ms_ = stamp_ms;
  return stamps_s_;
}

void LdlidarDriver::on_answer(const Received& received, Utime read) {
  const Utime arrival = read - line_time(received.bytes_after, search_.current());
  const Packet& packet = received.packet;
  SamplePacket samples;
  samples.continuous = received.continuous;
  samples.clock_s = unwrapped_s(packet.stamp_ms);
  samples.arrival = arrival;
  samples.left = arrival - line_time(kPacketSize, search_.current());
  for (int i = 0; i < kPacketSamples; ++i) {
    const Sample& sample = packet.samples[static_cast<std::size_t>(i)];
    const double angle_deg = sample_angle_deg(packet, i);
    samples.samples.push_back({angle_deg, deg_to_rad(options_.clockwise ? -angle_deg : angle_deg),
                               1e-3 * sample.range_mm, static_cast<double>(sample.intensity)});
  }
  scans_.add(samples);
  // Noise may hold one packet by chance, not two in a row.
  if (!heard_ && !received.continuous) return;
  if (!heard_) trouble_.clear();
  heard_ = true;
  deadline_ = arrival + kSilence;
}

std::string LdlidarDriver::state() const {
  if (!heard_) return with_trouble("looking for the laser", counts(), trouble_);
  return with_trouble("measuring, " + describe_scans(counts(), scans_.filter()) +
                          format(", %.1f a second, %.0f samples a second, %d baud",
                                 1.0 / scans_.turn_s(), scans_.sample_rate_hz(), search_.current()),
                      counts(), trouble_);
}

}  // namespace marco::drivers::ldlidar
