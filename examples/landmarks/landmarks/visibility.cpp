#include "landmarks/visibility.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

constexpr double kPriorVotes = 4.0;  // of which half were seen
constexpr double kMarginRad = 0.05;  // at the border of the view a landmark may be out of it
constexpr double kRangeMargin = 0.95;

}  // namespace

std::size_t Visibility::ring(double range_m) {
  const double at = kRingsPerOctave * std::log2(std::max(range_m, kFirstRingM) / kFirstRingM);
  return std::min<std::size_t>(static_cast<std::size_t>(at),
                               std::tuple_size_v<decltype(rings_)> - 1);
}

void Visibility::add_scan(const std::vector<Sighting>& sightings) {
  for (const Sighting& sighting : sightings) {
    largest_m_ = std::max(largest_m_, sighting.range_m);
    least_rad_ = std::min(least_rad_, sighting.bearing_rad);
    most_rad_ = std::max(most_rad_, sighting.bearing_rad);
  }
}

void Visibility::vote(double range_m, bool seen) {
  Votes& votes = rings_[ring(range_m)];
  votes.all += 1.0;
  votes.seen += seen ? 1.0 : 0.0;
}

double Visibility::probability(double range_m, double bearing_rad) const {
  if (range_m > kRangeMargin * largest_m_) return 0.0;
  if (bearing_rad < least_rad_ + kMarginRad || bearing_rad > most_rad_ - kMarginRad) return 0.0;
  const Votes& votes = rings_[ring(range_m)];
  return (votes.seen + 0.5 * kPriorVotes) / (votes.all + kPriorVotes);
}

}  // namespace marco::slam
