#include "common/input/own_body.hpp"

#include <algorithm>
#include <cmath>

#include "common/input/input_gates.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco {
namespace {

using namespace input_gates;

constexpr std::size_t kBins = 360;     // a degree each
constexpr int32_t kMostCounted = 100;  // then older scans count half
constexpr float kSameM = 0.03F;        // noise of cheap lasers near by
constexpr double kMarginM = 0.05;      // beyond the body's farthest return, kSameM and a little
constexpr std::size_t kBeside = 3;     // degrees: beyond the mixed ranges at an edge

bool is_return(float range_m) {
  return range_m > 0.0F && range_m < static_cast<float>(kFarthestReturnM);
}

std::vector<float> nearest_returns_m(const LaserScan& scan) {
  std::vector<float> nearest_m(kBins, 0.0F);
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    if (!is_return(scan.ranges_m[beam])) continue;
    float& nearest = nearest_m[degree_of(scan.bearing_rad(beam))];
    if (nearest == 0.0F || scan.ranges_m[beam] < nearest) nearest = scan.ranges_m[beam];
  }
  return nearest_m;
}

}  // namespace

bool BodyPart::has(double bearing_rad, float range_m) const {
  if (!(static_cast<double>(range_m) <= within_m)) return false;
  const double span_deg = last_deg - first_deg;
  const double width_deg = span_deg - 360.0 * std::floor(span_deg / 360.0) + 2.0;
  const double from_deg = rad_to_deg(bearing_rad) - first_deg + 1.0;
  return from_deg - 360.0 * std::floor(from_deg / 360.0) <= width_deg;
}

std::size_t blank(LaserScan& scan, const BodyPart& part) {
  std::size_t blanked = 0;
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    if (!part.has(scan.bearing_rad(beam), scan.ranges_m[beam])) continue;
    scan.ranges_m[beam] = 0.0F;
    ++blanked;
  }
  return blanked;
}

std::size_t degree_of(double bearing_rad) {
  const double deg = rad_to_deg(bearing_rad);
  return static_cast<std::size_t>(std::floor(deg - 360.0 * std::floor(deg / 360.0))) % kBins;
}

std::string describe(const std::vector<BodyPart>& parts) {
  std::string text;
  std::string channel;
  for (const BodyPart& part : parts) {
    if (part.channel != channel) {
      text += (text.empty() ? "" : "; ") + std::string("the robot itself is in view of ") +
              part.channel + ": ";
      channel = part.channel;
    } else {
      text += ", ";
    }
    text += format("%.0f to %.0f deg within %.2f m", part.first_deg, part.last_deg, part.within_m);
  }
  return text;
}

void OwnBody::Bin::note(float nearest_m, float before_m, float after_m) {
  const auto is_free = [&](float beside_m) {
    return std::abs(beside_m - nearest_m) > 0.05F + 0.15F * nearest_m;
  };
  if (same > 0 && std::abs(nearest_m - range_m) <= kSameM) {
    ++same;
    free_before += is_free(before_m) ? 1 : 0;
    free_after += is_free(after_m) ? 1 : 0;
    range_m += (nearest_m - range_m) / static_cast<float>(std::min(same, 10));
  } else if (++other > same && nearest_m <= static_cast<float>(kBodyWithinM)) {
    *this = {nearest_m, 1};
  }
  if (same + other <= kMostCounted) return;
  for (int32_t* count : {&same, &other, &free_before, &free_after}) *count /= 2;
}

bool OwnBody::Bin::is_body() const {
  return same >= kBodyScans && kBodyPart * static_cast<double>(same + other) <= same;
}

bool OwnBody::has_changed(const std::vector<float>& nearest_m) const {
  int changed = 0, compared = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    const float now = nearest_m[i], before = last_m_[i];
    if (now == 0.0F || before == 0.0F) continue;
    if (std::max(now, before) <= static_cast<float>(kBodyWithinM)) continue;
    ++compared;
    changed += std::abs(now - before) > 0.1F + 0.05F * std::min(now, before) ? 1 : 0;
  }
  constexpr int kFewest = 20;  // bins: a part of fewer is chance
  return compared >= kFewest && changed >= kChangedPart * compared;
}

bool OwnBody::look(const LaserScan& scan) {
  std::vector<float> nearest_m = nearest_returns_m(scan);
  if (last_m_.empty()) {
    bins_.resize(kBins);
    last_m_ = std::move(nearest_m);
    return false;
  }
  if (!has_changed(nearest_m)) return false;
  ++samples_;
  for (std::size_t i = 0; i < kBins; ++i) {
    if (nearest_m[i] == 0.0F) continue;
    bins_[i].note(nearest_m[i], nearest_m[(i + kBins - kBeside) % kBins],
                  nearest_m[(i + kBeside) % kBins]);
  }
  last_m_ = std::move(nearest_m);
  std::vector<BodyPart> found = parts_in(scan.channel);
  if (found == parts_) return false;
  parts_ = std::move(found);
  return true;
}

std::vector<std::array<std::size_t, 2>> OwnBody::sectors() const {
  std::vector<std::array<std::size_t, 2>> sectors;
  for (std::size_t i = 0; i < kBins; ++i) {
    if (!bins_[i].is_body()) continue;
    // Of beams a degree apart none falls into some bins.
    if (!sectors.empty() && sectors.back()[1] + 2 >= i) {
      sectors.back()[1] = i;
    } else {
      sectors.push_back({i, i});
    }
  }
  if (sectors.size() > 1 && sectors.front()[0] + kBins <= sectors.back()[1] + 2) {
    sectors.back()[1] = sectors.front()[1] + kBins;
    sectors.erase(sectors.begin());
  }
  return sectors;
}

std::vector<BodyPart> OwnBody::parts_in(const std::string& channel) const {
  std::vector<BodyPart> parts;
  std::size_t body = 0;
  for (const auto& [first, last] : sectors()) {
    const Bin &begin = bins_[first], &end = bins_[last % kBins];
    if (begin.free_before < kFreeBeside * begin.same || end.free_after < kFreeBeside * end.same) {
      continue;
    }
    float farthest_m = 0.0F;
    for (std::size_t i = first; i <= last; ++i) {
      const Bin& bin = bins_[i % kBins];
      if (bin.is_body()) farthest_m = std::max(farthest_m, bin.range_m);
    }
    const double within_m = std::ceil((static_cast<double>(farthest_m) + kMarginM) * 100.0) / 100.0;
    parts.push_back({channel, static_cast<double>(first), static_cast<double>(last + 1), within_m});
    body += last + 1 - first;
  }
  // A laser whose every beam is the same all the time is broken in another way.
  return 2 * body > kBins ? std::vector<BodyPart>{} : parts;
}

}  // namespace marco
