#include "common/input/beam_order.hpp"

#include <algorithm>
#include <cmath>

#include "common/input/beam_times.hpp"
#include "common/input/input_gates.hpp"

namespace marco {
namespace {

// Turning scans: with fewer nothing is concluded, and after the most there is nothing to find.
constexpr int kFewest = 20, kMost = 300;

using input_gates::kSureSigmas;

// Of the loss of the one direction at most, the loss of the other. If beams were measured at once
// both would lose the same; if in the other direction, it would lose nothing.
constexpr double kClearlyLess = 0.5;

}  // namespace

std::vector<float> reordered_times_s(const LaserScan& scan,
                                     double period_s,
                                     BeamOrder now,
                                     BeamOrder order) {
  std::vector<float> times_s(scan.size(), 0.0F);
  if (const auto span = span_of_turn(scan, period_s)) {
    const float sum_s = span->first_s + span->last_s;
    for (std::size_t beam = 0; beam < times_s.size(); ++beam) {
      const float time_s = scan.time_offsets_s[beam];
      times_s[beam] = order == BeamOrder::at_once ? span->first_s
                      : order == now              ? time_s
                                                  : sum_s - time_s;
    }
    return times_s;
  }
  const float first_s = scan.time_offsets_s.empty() ? 0.0F : scan.time_offsets_s.front();
  const double turn_s = order == BeamOrder::at_once ? 0.0 : period_s;
  for (std::size_t beam = 0; beam < times_s.size(); ++beam) {
    const std::size_t turned = order == BeamOrder::forwards ? beam : times_s.size() - 1 - beam;
    const double part = static_cast<double>(turned) / static_cast<double>(times_s.size());
    times_s[beam] = first_s + static_cast<float>(turn_s * part);
  }
  return times_s;
}

std::vector<BeamOrder> BeamOrderJudge::rivals() const {
  std::vector<BeamOrder> rivals;
  for (const auto order : {BeamOrder::forwards, BeamOrder::backwards, BeamOrder::at_once}) {
    if (order != present_) rivals.push_back(order);
  }
  return rivals;
}

BeamVerdict BeamOrderJudge::look(LaserScan& scan, double period_s) {
  if (!is_turn_period(period_s) || !sees_all_round(scan)) return {};
  const auto given = span_of_turn(scan, period_s) ? BeamOrder::forwards : BeamOrder::at_once;
  const bool found = decided_ || (given_ && present_ != *given_);
  if (given != given_ && found) return {};
  // The first scans' stamps may lie so near to each other that no turn fits between them.
  if (given != given_) {
    *this = {};
    present_ = *(given_ = given);
  }
  BeamVerdict verdict;
  verdict.order = present_;
  if (present_ != given) scan.time_offsets_s = reordered_times_s(scan, period_s, given, present_);
  if (!decided_) verdict.rivals = rivals();
  return verdict;
}

double BeamOrderJudge::sigmas(const Sums& sums) const {
  const double mean = sums.sum / scans_;
  const double variance = std::max(0.0, sums.squares / scans_ - mean * mean);
  return variance > 0.0 ? mean / std::sqrt(variance / scans_) : 0.0;
}

std::optional<std::size_t> BeamOrderJudge::better_rival() const {
  if (present_ == BeamOrder::at_once) {
    const double lead = sigmas(sums_[2]);
    if (std::abs(lead) < kSureSigmas) return std::nullopt;
    const std::size_t winner = lead > 0.0 ? 0 : 1;
    const double loss = -sums_[winner].sum, other_loss = -sums_[1 - winner].sum;
    if (loss > kClearlyLess * other_loss) return std::nullopt;
    return winner;
  }
  const std::size_t best = sums_[0].sum > sums_[1].sum ? 0 : 1;
  if (sigmas(sums_[best]) < kSureSigmas) return std::nullopt;
  return best;
}

bool BeamOrderJudge::note(const BeamVerdict& scan, const std::vector<double>& misfits_m2) {
  // A scan may have waited while the order changed.
  if (decided_ || scan.order != present_ || misfits_m2.size() != 3) return false;
  if (!(*std::min_element(misfits_m2.begin(), misfits_m2.end()) > 0.0)) return false;
  const double first = std::log(misfits_m2[0] / misfits_m2[1]);
  const double second = std::log(misfits_m2[0] / misfits_m2[2]);
  const double gains[] = {first, second, first - second};
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    sums_[i].sum += gains[i];
    sums_[i].squares += gains[i] * gains[i];
  }
  if (++scans_ < kFewest) return false;
  const auto better = better_rival();
  const bool both_worse = sigmas(sums_[0]) < -kSureSigmas && sigmas(sums_[1]) < -kSureSigmas;
  const bool alike = std::abs(sigmas(sums_[2])) < kSureSigmas;
  const bool sure = both_worse && (alike || present_ != BeamOrder::at_once);
  decided_ = !better && (sure || scans_ >= kMost);
  if (!better) return false;
  // What fits better against the map's own favour is sure; of the two directions only the better
  // one was told.
  const bool against_the_map = present_ != BeamOrder::at_once;
  present_ = scan.rivals.at(*better);
  decided_ = against_the_map && present_ != BeamOrder::at_once;
  sums_.assign(3, {});
  scans_ = 0;
  return true;
}

std::string BeamOrderJudge::description() const {
  if (present_ == given_) return "beam times are correct after all: unchanged";
  if (given_ == BeamOrder::forwards) {
    return present_ == BeamOrder::at_once ? "beams are measured simultaneously, despite their times"
                                          : "beam times run backwards: reversed";
  }
  return present_ == BeamOrder::forwards
             ? "beam times missing: spread over the turn, first to last"
             : "beam times missing: spread over the turn, last to first";
}

}  // namespace marco
