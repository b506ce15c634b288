#include "slam/line_slam/ekf/wall_evidence.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

double probability_of(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

}  // namespace

WallEvidence::WallEvidence(const WallEvidenceOptions& options, double length_m)
    : bin_m_(options.bin_m), length_m_(length_m) {
  const auto bins = static_cast<std::size_t>(std::max(1.0, std::ceil(length_m / bin_m_)));
  log_odds_.assign(bins, static_cast<float>(options.hit_log_odds));
}

void WallEvidence::set_extent(double before_start_m, double length_m) {
  offset_m_ -= before_start_m;
  length_m_ = length_m;
  if (offset_m_ < 0.0) {
    const auto more = static_cast<std::size_t>(std::ceil(-offset_m_ / bin_m_));
    log_odds_.insert(log_odds_.begin(), more, 0.0F);
    offset_m_ += static_cast<double>(more) * bin_m_;
  }
  const auto bins =
      static_cast<std::size_t>(std::max(1.0, std::ceil((offset_m_ + length_m_) / bin_m_)));
  if (bins > log_odds_.size()) log_odds_.resize(bins, 0.0F);
}

void WallEvidence::vote(double at_m, int value) {
  const double bin = std::floor((at_m + offset_m_) / bin_m_);
  if (!(bin >= 0.0 && bin < static_cast<double>(log_odds_.size()))) return;
  votes_.resize(log_odds_.size(), 0);
  votes_[static_cast<std::size_t>(bin)] += value;
}

void WallEvidence::count_votes(const WallEvidenceOptions& options) {
  for (std::size_t i = 0; i < votes_.size(); ++i) {
    if (votes_[i] == 0) continue;
    const double change = votes_[i] > 0 ? options.hit_log_odds : -options.passed_log_odds;
    log_odds_[i] = static_cast<float>(std::clamp(static_cast<double>(log_odds_[i]) + change,
                                                 -options.limit_log_odds, options.limit_log_odds));
  }
  votes_.clear();
}

void WallEvidence::forget(const WallEvidenceOptions& options) {
  const auto once = static_cast<float>(options.hit_log_odds);
  for (float& value : log_odds_) value = std::clamp(value, 0.0F, once);
}

void WallEvidence::merge(const WallEvidence& other, double offset_m) {
  for (std::size_t i = 0; i < other.log_odds_.size(); ++i) {
    const double at_m = (static_cast<double>(i) + 0.5) * other.bin_m_ - other.offset_m_ + offset_m;
    const double bin = std::floor((at_m + offset_m_) / bin_m_);
    if (bin < 0.0 || bin >= static_cast<double>(log_odds_.size())) continue;
    float& mine = log_odds_[static_cast<std::size_t>(bin)];
    if (std::abs(other.log_odds_[i]) > std::abs(mine)) mine = other.log_odds_[i];
  }
}

double WallEvidence::existence() const {
  if (log_odds_.empty()) return 0.0;
  return probability_of(static_cast<double>(*std::max_element(log_odds_.begin(), log_odds_.end())));
}

std::vector<WallEvidence::Run> WallEvidence::runs(const WallEvidenceOptions& options) const {
  std::vector<Run> found;
  bool open = false;
  for (std::size_t i = 0; i < log_odds_.size(); ++i) {
    const double from_m = std::max(0.0, static_cast<double>(i) * bin_m_ - offset_m_);
    const double to_m = std::min(length_m_, static_cast<double>(i + 1) * bin_m_ - offset_m_);
    const bool stands =
        probability_of(static_cast<double>(log_odds_[i])) > options.seen_probability;
    if (to_m <= from_m) continue;
    if (stands && open) found.back().to_m = to_m;
    if (stands && !open) found.push_back({from_m, to_m});
    open = stands;
  }
  return found;
}

}  // namespace marco::slam
