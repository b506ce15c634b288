#include "slam/doctor/contradiction_reasons.hpp"

#include <algorithm>

#include "lcm_tools/base/format.hpp"
#include "slam/doctor/doctor_gates.hpp"
#include "slam/doctor/rematch.hpp"
#include "slam/map/visits.hpp"

namespace marco::slam {
namespace {

// Keyframes, 4 m of path: what went wrong once shows in neighbours, and they are one reason.
constexpr std::size_t kStretchKeyframes = 12;
constexpr int kFewestPoints = 200;       // seen again, all together
constexpr std::size_t kMostReasons = 5;  // reported; people read the report
constexpr int kMatchesOfOne = 3;         // tried of one stretch: they take the time
constexpr double kConfirmed = 0.9;       // of the points

struct Stretch {
  std::size_t first;
  int agreeing;
  int contradicting;

  int seen() const { return agreeing + contradicting; }
  double share() const { return static_cast<double>(contradicting) / seen(); }
  std::size_t last() const { return first + kStretchKeyframes - 1; }
  bool holds(int key) const {
    return static_cast<std::size_t>(key) >= first && static_cast<std::size_t>(key) <= last();
  }
};

// What newer keyframes say of older ones, by the newer.
std::vector<Visit> sums_of(const std::vector<Visit>& visits, std::size_t keys) {
  std::vector<Visit> sums(keys);
  for (const Visit& visit : visits) {
    Visit& sum = sums[static_cast<std::size_t>(visit.newer)];
    sum.agreeing += visit.agreeing;
    sum.contradicting += visit.contradicting;
  }
  return sums;
}

// All that can be judged, the worst first.
std::vector<Stretch> stretches_of(const std::vector<Visit>& sums) {
  std::vector<Stretch> stretches;
  Stretch window{0, 0, 0};
  for (std::size_t i = 0; i < sums.size(); ++i) {
    window.agreeing += sums[i].agreeing;
    window.contradicting += sums[i].contradicting;
    if (i + 1 < kStretchKeyframes) continue;
    window.first = i + 1 - kStretchKeyframes;
    if (window.seen() >= kFewestPoints) stretches.push_back(window);
    window.agreeing -= sums[window.first].agreeing;
    window.contradicting -= sums[window.first].contradicting;
  }
  std::stable_sort(stretches.begin(), stretches.end(),
                   [](const Stretch& a, const Stretch& b) { return a.share() > b.share(); });
  return stretches;
}

std::vector<Visit> worst_visits(const std::vector<Visit>& visits, const Stretch& stretch) {
  std::vector<Visit> found;
  for (const Visit& visit : visits) {
    if (stretch.holds(visit.newer)) found.push_back(visit);
  }
  std::stable_sort(found.begin(), found.end(), [](const Visit& a, const Visit& b) {
    return a.contradicting > b.contradicting;
  });
  return found;
}

// The loop in force that the rest contradicts most, of those that end in the stretch.
const Loop* loop_into(const MapEvidence& map, const Stretch& stretch) {
  const Loop* worst = nullptr;
  for (const Loop& loop : map.loops) {
    if (!loop.is_inlier || (!stretch.holds(loop.from) && !stretch.holds(loop.to))) continue;
    if (worst == nullptr || loop.shift_m > worst->shift_m) worst = &loop;
  }
  return worst;
}

std::optional<Rematch> add_remedy(const MapEvidence& map,
                                  const Stretch& stretch,
                                  const std::vector<Visit>& visits,
                                  Reason& reason) {
  const auto utime = [&map](int key) { return map.keys[static_cast<std::size_t>(key)].utime; };
  for (std::size_t i = 0; i < visits.size() && i < kMatchesOfOne; ++i) {
    const auto better = match_again(map.keys, visits[i].older, visits[i].newer);
    if (!better) continue;
    const Utime older = utime(visits[i].older), newer = utime(visits[i].newer);
    if (older <= newer) {
      reason.remedies.push_back({MapEdit::Kind::add_loop, older, newer, better->older_from_newer});
    } else {
      reason.remedies.push_back(
          {MapEdit::Kind::add_loop, newer, older, better->older_from_newer.inverse()});
    }
    return better;
  }
  if (const Loop* loop = loop_into(map, stretch)) {
    reason.remedies.push_back({MapEdit::Kind::forbid_loop,
                               std::min(utime(loop->from), utime(loop->to)),
                               std::max(utime(loop->from), utime(loop->to)),
                               {}});
  }
  return std::nullopt;
}

Reason reason_of(const MapEvidence& map, const Stretch& stretch, const std::vector<Visit>& visits) {
  Reason reason;
  reason.cause = Reason::Cause::contradiction;
  reason.from = map.keys[stretch.first].utime;
  reason.to = map.keys[stretch.last()].utime;
  if (reason.to < reason.from) std::swap(reason.from, reason.to);
  const std::vector<Visit> worst = worst_visits(visits, stretch);
  reason.place_m =
      map.keys[static_cast<std::size_t>(worst.front().newer)].world_from_robot.translation_m();
  for (std::size_t key = stretch.first; key <= stretch.last(); ++key) {
    reason.newer_keys.push_back(static_cast<int>(key));
  }
  for (const Visit& visit : worst) {
    if (visit.contradicting > 0) reason.older_keys.push_back(visit.older);
  }
  const auto better = add_remedy(map, stretch, worst, reason);
  reason.verdict =
      stretch.share() >= doctor_gates::kContradictingWrong ? Verdict::wrong : Verdict::doubtful;
  reason.why =
      format("%.0f %% of what was seen here before is now elsewhere", 100.0 * stretch.share());
  if (better) {
    reason.why += format("; %.2f m and %.1f deg off, %.0f %% would match instead of %.0f %%",
                         better->shift_m, rad_to_deg(better->turn_rad), 100.0 * better->overlap,
                         100.0 * better->overlap_before);
  }
  return reason;
}

double confirmed_part(const std::vector<Visit>& sums) {
  constexpr int kFewest = 10;  // points, of which one may be wrong (kConfirmed)
  double confirmed = 0.0;
  for (const Visit& sum : sums) {
    confirmed += sum.seen() >= kFewest && sum.agreeing >= kConfirmed * sum.seen() ? 1.0 : 0.0;
  }
  return sums.empty() ? 0.0 : confirmed / static_cast<double>(sums.size());
}

}  // namespace

void examine_visits(const MapEvidence& map, Diagnosis& diagnosis) {
  const std::vector<Visit> visits = find_visits(map.keys);
  const std::vector<Visit> sums = sums_of(visits, map.keys.size());
  DoctorFigures& figures = diagnosis.figures;
  double agreeing = 0.0, contradicting = 0.0;
  for (const Visit& sum : sums) {
    agreeing += sum.agreeing;
    contradicting += sum.contradicting;
  }
  figures.contradicting_in_all = contradicting / std::max(1.0, agreeing + contradicting);
  figures.confirmed_keyframes = confirmed_part(sums);
  const std::vector<Stretch> stretches = stretches_of(sums);
  if (!stretches.empty()) figures.contradicting = stretches.front().share();
  std::vector<Stretch> told;
  for (const Stretch& stretch : stretches) {
    if (stretch.share() < doctor_gates::kContradicting || told.size() == kMostReasons) break;
    const bool apart = std::all_of(told.begin(), told.end(), [&](const Stretch& other) {
      return stretch.last() < other.first || other.last() < stretch.first;
    });
    if (!apart) continue;
    told.push_back(stretch);
    diagnosis.reasons.push_back(reason_of(map, stretch, visits));
  }
}

}  // namespace marco::slam
