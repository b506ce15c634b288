#include "drivers/rplidar/turn_assembler.hpp"

#include "common/pose2.hpp"
#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::rplidar {

void TurnAssembler::start(double sample_s) {
  clock_.start(sample_s);
  capsule_.reset();
  gatherer_.drop_turn();
  usual_span_deg_ = 0.0;
}

void TurnAssembler::note_arrival(Utime arrival) {
  last_arrival_ = arrival;
  clock_.note_arrival(arrival);
}

void TurnAssembler::lose_count() {
  clock_.lose_count();
  capsule_.reset();
  usual_span_deg_ = 0.0;
  gatherer_.drop_turn();
}

void TurnAssembler::add_node(const Block& block, Utime arrival) {
  if (!block.continuous) {
    ++counts_.drops["lost_samples"];
    lose_count();
  }
  const int64_t sample = clock_.count();
  // Of nodes that came together the last one waited least.
  const bool last = block.bytes_after < 2 * kNodeSize;
  if (last) note_arrival(arrival - line_time(kNodeSize, baud_));
  const Node& node = block.node;
  // Quality 0 says nothing: some devices send no other.
  add_sample(sample, node.angle_q6 / 64.0, node.distance_q2 * 0.25e-3, node.first);
}

// A capsule lost without a trace doubles the step of the start angles.
bool TurnAssembler::follows_directly(const Capsule& next) {
  double span_deg = (next.start_q6 - capsule_->start_q6) / 64.0;
  if (span_deg < 0.0) span_deg += 360.0;
  if (usual_span_deg_ == 0.0) usual_span_deg_ = span_deg;
  if (span_deg > 1.6 * usual_span_deg_ || span_deg < 0.4 * usual_span_deg_) return false;
  usual_span_deg_ += 0.1 * (span_deg - usual_span_deg_);
  return true;
}

void TurnAssembler::add_capsule(const Block& block, Utime arrival) {
  const std::optional<Capsule> previous = capsule_;
  const bool whole =
      !previous || (block.continuous && !block.capsule.first && follows_directly(block.capsule));
  if (!whole) {
    ++counts_.drops["lost_capsule"];
    lose_count();
  }
  if (previous && whole) {
    for (const PlacedSample& sample : samples_of(*previous, block.capsule)) {
      // Offsets shift a sample back by a few degrees. A new turn is a long way back.
      const bool new_turn = sample.angle_deg < last_angle_deg_ - 180.0;
      add_sample(clock_.count(), sample.angle_deg, sample.range_mm * 1e-3, new_turn);
    }
  }
  capsule_ = block.capsule;
  // It leaves the laser after its own last sample, a capsule behind the one counted.
  note_arrival(arrival - line_time(capsule_size(block.kind), baud_) -
               Duration::from_seconds(block.capsule.samples * clock_.sample_s()));
}

void TurnAssembler::add_sample(int64_t sample, double angle_deg, double range_m, bool new_turn) {
  last_angle_deg_ = angle_deg;
  if (new_turn && gatherer_.begin_turn(last_arrival_)) ++counts_.scans;
  gatherer_.add({sample, -deg_to_rad(angle_deg), range_m});
}

}  // namespace marco::drivers::rplidar
