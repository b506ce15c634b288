#include "slam/session/mending.hpp"

#include "slam/doctor/contradiction_reasons.hpp"
#include "slam/map/visits.hpp"

namespace marco::slam {
namespace {

constexpr int kMostTries = 10;  // each may take a loop away; and against hanging

// What the passes say of each other, in points.
struct Consistency {
  double agreeing = 0.0;
  double contradicting = 0.0;

  explicit Consistency(const Slam& slam) {
    for (const Visit& visit : find_visits(slam.keys())) {
      agreeing += visit.agreeing;
      contradicting += visit.contradicting;
    }
  }
  // Parts that are moved apart contradict less, and agree less.
  bool is_better_than(const Consistency& before) const {
    return agreeing > before.agreeing &&
           contradicting * before.agreeing < before.contradicting * agreeing;
  }
};

// The likeliest of each contradiction: others of its are alternatives.
MapEdits remedies_of(const Slam& slam) {
  MapEvidence evidence;
  evidence.keys = slam.keys();
  evidence.loops = slam.loops();
  Diagnosis diagnosis;
  examine_visits(evidence, diagnosis);
  MapEdits remedies;
  for (const Reason& reason : diagnosis.reasons) {
    if (!reason.remedies.empty()) remedies.push_back(reason.remedies.front());
  }
  return remedies;
}

}  // namespace

MapEdits mend(Slam& slam) {
  MapEdits done;
  if (slam.keys().size() < 2) return done;
  MapEdits remedies = remedies_of(slam);
  for (int i = 0; i < kMostTries && !remedies.empty(); ++i) {
    const Consistency before(slam);
    const SlamState undone = slam.state();
    slam.apply(remedies);
    slam.finish();
    if (Consistency(slam).is_better_than(before)) {
      done.insert(done.end(), remedies.begin(), remedies.end());
      remedies = remedies_of(slam);
      continue;
    }
    slam.restore(undone);
    // One of them may be wrong: the likeliest alone.
    if (remedies.size() == 1) break;
    remedies.resize(1);
  }
  return done;
}

}  // namespace marco::slam
