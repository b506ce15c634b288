#include "landmarks/landmark_slam.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

// Evidence, in log odds. A vote weighs by how much the view changed since the scan before.
constexpr double kEvidenceAtFirst = 1.0;
constexpr double kEvidenceSeen = 0.7;
constexpr double kMostEvidence = 8.0;
constexpr double kLeastEvidence = -2.0;
constexpr double kMissPart = 0.5;          // of what independent misses would say
constexpr double kNewViewPart = 0.2;       // moved by this part of the range, a view is another one
constexpr double kLeastProbability = 0.3;  // what is seen more rarely says nothing when missed
constexpr double kOcclusionRad = 0.06;     // beside a nearer landmark

constexpr int kStepsToBegin = 15;  // of learning, until the beginning is gone through again
constexpr std::size_t kMostToBegin = 3000;  // scans; without learning it is never done

constexpr double kDoubledGate2 = 7.4;  // chi-square, 2 degrees of freedom, 97.5 %
constexpr double kNeighboursM = 5.0;
constexpr int kKnownSightings = 20;  // a landmark that may teach the noise

}  // namespace

void LandmarkSlam::Record::count(const Sighting& sighting) {
  ++times_seen;
  if (sighting.diameter_m > 0.0) {
    diameter_sum_m += sighting.diameter_m;
    ++diameters;
  }
}

LandmarkSlam::LandmarkSlam(const LandmarkSlamOptions& options)
    : options_(options), filter_(options.set_up), learner_(options.noise) {
  validate(options, "landmarks");
  if (options.learn_noise) beginning_.emplace();
}

bool LandmarkSlam::process(const WheelVelocity& sample) {
  if (beginning_) beginning_->wheels.push_back(sample);
  return wheels_.add(sample, filter_.set_up(), learner_.noise());
}

Pose2 LandmarkSlam::world_from_robot() const {
  return filter_.world_from_robot() * wheels_.motion().start_from_end;
}

LandmarkUpdate LandmarkSlam::process(const SightingScan& scan) {
  const LandmarkUpdate update = take(scan);
  if (!beginning_) return update;
  beginning_->scans.push_back(scan);
  if (learner_.steps() >= kStepsToBegin) begin_again();
  if (beginning_ && beginning_->scans.size() > kMostToBegin) beginning_.reset();
  return update;
}

void LandmarkSlam::begin_again() {
  LandmarkSlamOptions learned = options_;
  learned.noise = learner_.noise();
  LandmarkSlam again(learned);
  again.beginning_.reset();
  again.learner_ = learner_;
  again.learner_.lose_robot();
  again.correlation_ = correlation_;
  again.correlation_.renumber();
  std::size_t next = 0;
  for (const SightingScan& scan : beginning_->scans) {
    while (next < beginning_->wheels.size() && beginning_->wheels[next].utime <= scan.utime) {
      again.process(beginning_->wheels[next++]);
    }
    again.take(scan);
  }
  again.options_ = options_;
  *this = std::move(again);
}

LandmarkUpdate LandmarkSlam::take(const SightingScan& scan) {
  std::vector<Sighting> sightings;
  for (const Sighting& sighting : scan.sightings) {
    const bool usable = std::isfinite(sighting.range_m) && std::isfinite(sighting.bearing_rad) &&
                        sighting.range_m > 0.0;
    if (usable) sightings.push_back(sighting);
  }
  wheels_.carry_to(scan.utime, filter_.set_up(), learner_.noise());
  const WheelMotion motion = wheels_.motion();
  wheels_.restart();
  WheelMotion believed = motion;
  if (options_.learn_noise) believed.noise *= correlation_.noise_factor();
  filter_.move(believed);

  LandmarkUpdate update;
  visibility_.add_scan(sightings);
  const SightingNoise noise = independent_noise();
  const std::vector<SightingMatch> matches =
      associate_sightings(filter_, sightings, noise, options_.gate_probability);
  std::vector<SightingOf> seen, known;
  std::vector<Sighting> unexplained;
  for (std::size_t k = 0; k < sightings.size(); ++k) {
    const int landmark = matches[k].landmark;
    if (landmark == SightingMatch::kNew) unexplained.push_back(sightings[k]);
    if (landmark == SightingMatch::kUnclear) ++update.unclear;
    if (landmark < 0) continue;
    seen.push_back({sightings[k], landmark});
    Record& record = records_[static_cast<std::size_t>(landmark)];
    record.count(sightings[k]);
    if (record.times_seen > kKnownSightings) known.push_back(seen.back());
  }
  update.paired = static_cast<int>(seen.size());
  correct(seen);
  if (options_.learn_noise) learner_.add_scan(motion, known, filter_);
  note_neighbours(seen);
  for (const Sighting& sighting : provisional_.add_scan(unexplained, filter_, visibility_, noise,
                                                        options_.confirm_sightings)) {
    add(sighting);
    ++update.added;
  }
  // Both give indices out again, so what names landmarks by index ends here.
  update.removed = judge(matches, motion.start_from_end.translation_m().norm());
  if (update.removed == 0) update.joined = join_doubled(seen);
  return update;
}

void LandmarkSlam::correct(const std::vector<SightingOf>& seen) {
  const SightingNoise& noise = learner_.noise();
  const Eigen::Array2d own(noise.range_sigma_m, noise.bearing_sigma_rad);
  ++scan_;
  for (const SightingOf& one : seen) {
    const Record& record = records_[static_cast<std::size_t>(one.landmark)];
    if (record.times_seen <= kKnownSightings) continue;
    const PointInnovation rows = filter_.innovation(one);
    const Eigen::Array2d variance =
        filter_.innovation_covariance(rows, one.landmark, rows, one.landmark).diagonal().array() +
        own.square();
    correlation_.add(record.id, rows.innovation.array() / variance.sqrt(), scan_);
  }
  filter_.correct(seen, independent_noise());
}

SightingNoise LandmarkSlam::independent_noise() const {
  SightingNoise noise = learner_.noise();
  if (!options_.learn_noise) return noise;
  const double factor = std::sqrt(correlation_.noise_factor());
  noise.range_sigma_m *= factor;
  noise.bearing_sigma_rad *= factor;
  return noise;
}

void LandmarkSlam::add(const Sighting& sighting) {
  filter_.add(sighting, independent_noise());
  Record record;
  record.id = next_id_++;
  record.evidence = kEvidenceAtFirst;
  record.count(sighting);
  records_.push_back(record);
}

void LandmarkSlam::forget(int index) {
  records_[static_cast<std::size_t>(index)] = records_.back();
  records_.pop_back();
}

void LandmarkSlam::note_neighbours(const std::vector<SightingOf>& seen) {
  for (const SightingOf& a : seen) {
    for (const SightingOf& b : seen) {
      if (a.landmark == b.landmark) continue;
      const Eigen::Vector2d apart = filter_.landmark(a.landmark) - filter_.landmark(b.landmark);
      if (apart.norm() > kNeighboursM) continue;
      records_[static_cast<std::size_t>(a.landmark)].seen_beside.insert(
          records_[static_cast<std::size_t>(b.landmark)].id);
    }
  }
}

bool LandmarkSlam::are_one(int a, int b) const {
  const Record& first = records_[static_cast<std::size_t>(a)];
  const Record& second = records_[static_cast<std::size_t>(b)];
  if (first.seen_beside.contains(second.id) || second.seen_beside.contains(first.id)) return false;
  const Eigen::Vector2d apart = filter_.landmark(a) - filter_.landmark(b);
  if (apart.norm() > kNeighboursM) return false;
  const Eigen::Matrix2d covariance = filter_.relative_covariance(a, b);
  if (apart.dot(covariance.inverse() * apart) > kDoubledGate2) return false;
  double next_m = std::numeric_limits<double>::infinity();  // to a landmark that is neither
  for (int i = 0; i < filter_.size(); ++i) {
    if (i == a || i == b) continue;
    next_m = std::min(next_m, (filter_.landmark(i) - filter_.landmark(a)).norm());
  }
  const double sigma_m = std::sqrt(
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvalues().maxCoeff());
  return 4.0 * sigma_m < next_m;
}

int LandmarkSlam::join_doubled(const std::vector<SightingOf>& seen) {
  for (const SightingOf& one : seen) {
    for (int other = 0; other < filter_.size(); ++other) {
      if (other == one.landmark || !are_one(one.landmark, other)) continue;
      const int kept = std::min(one.landmark, other), gone = std::max(one.landmark, other);
      Record& record = records_[static_cast<std::size_t>(kept)];
      const Record& doubled = records_[static_cast<std::size_t>(gone)];
      record.evidence = std::max(record.evidence, doubled.evidence);
      record.times_seen += doubled.times_seen;
      record.diameter_sum_m += doubled.diameter_sum_m;
      record.diameters += doubled.diameters;
      record.seen_beside.insert(doubled.seen_beside.begin(), doubled.seen_beside.end());
      filter_.join(kept, gone);
      forget(gone);
      return 1;  // indices have changed; the next scan finds the next one
    }
  }
  return 0;
}

int LandmarkSlam::judge(const std::vector<SightingMatch>& matches, double moved_m) {
  struct View {
    double range_m, bearing_rad;
  };
  std::vector<View> views;
  std::vector<bool> was_seen(records_.size(), false);
  for (int i = 0; i < filter_.size(); ++i) {
    const Eigen::Vector2d at = filter_.in_sensor(i);
    views.push_back({at.norm(), std::atan2(at.y(), at.x())});
  }
  std::vector<View> nearer;
  for (const SightingMatch& match : matches) {
    if (match.landmark < 0) continue;
    was_seen[static_cast<std::size_t>(match.landmark)] = true;
    nearer.push_back(views[static_cast<std::size_t>(match.landmark)]);
  }
  for (std::size_t i = 0; i < records_.size(); ++i) {
    const View& view = views[i];
    const double probability = visibility_.probability(view.range_m, view.bearing_rad);
    if (probability == 0.0 && !was_seen[i]) continue;
    Record& record = records_[i];
    const double weight = std::min(1.0, moved_m / (kNewViewPart * std::max(view.range_m, 1e-3)));
    if (was_seen[i]) {
      record.evidence = std::min(kMostEvidence, record.evidence + weight * kEvidenceSeen);
    } else {
      const bool hidden = std::any_of(nearer.begin(), nearer.end(), [&](const View& front) {
        return front.range_m < view.range_m &&
               std::abs(normalize_angle(front.bearing_rad - view.bearing_rad)) < kOcclusionRad;
      });
      if (hidden) continue;
      if (probability > kLeastProbability) {
        record.evidence += weight * kMissPart * std::log(1.0 - std::min(probability, 0.98));
      }
    }
    if (record.evidence > 0.5 * kMostEvidence) visibility_.vote(view.range_m, was_seen[i]);
  }
  int removed = 0;
  for (int i = filter_.size() - 1; i >= 0; --i) {
    if (records_[static_cast<std::size_t>(i)].evidence > kLeastEvidence) continue;
    filter_.remove(i);
    forget(i);
    ++removed;
  }
  return removed;
}

std::vector<MapLandmark> LandmarkSlam::landmarks(double least_existence) const {
  std::vector<MapLandmark> list;
  for (int i = 0; i < filter_.size(); ++i) {
    const Record& record = records_[static_cast<std::size_t>(i)];
    MapLandmark landmark;
    landmark.existence = 1.0 / (1.0 + std::exp(-record.evidence));
    if (landmark.existence < least_existence) continue;
    landmark.id = record.id;
    landmark.in_world_m = filter_.landmark(i);
    landmark.covariance = filter_.landmark_covariance(i);
    landmark.times_seen = record.times_seen;
    if (record.diameters > 0) {
      landmark.diameter_m = record.diameter_sum_m / static_cast<double>(record.diameters);
    }
    list.push_back(landmark);
  }
  std::sort(list.begin(), list.end(),
            [](const MapLandmark& a, const MapLandmark& b) { return a.id < b.id; });
  return list;
}

}  // namespace marco::slam
