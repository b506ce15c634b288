#include <algorithm>
#include <cmath>

#include "slam/line_slam/lines/line_extractor.hpp"

namespace marco::slam {

// Variance of a point across its line: the range's error as far as the beam stands on the wall,
// the bearing's as far as it grazes it.
void LineExtractor::choose_members(int from, int to, const Line& line) {
  const double rms2 = std::min(square(line.rms_m), square(0.5 * options_.split_distance_m));
  const double limit2 = square(options_.split_distance_m);
  const double sensor2 = square(line.across_of(scan_->sensor_m));
  const double range_part = square(scan_->range_sigma_m) * sensor2;
  const double bearing_part = square(scan_->bearing_sigma_rad);
  const double surface2 = square(options_.surface_sigma_m), trim2 = square(options_.trim_sigmas);
  members_.clear();
  weights_.clear();
  for (int i = from; i <= to; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double across2 = square(line.across_of(x_[k], y_[k]));
    if (across2 > limit2) continue;
    const double sigma2 = std::min(square(scan_->range_sigma_m), range_part * inverse_range2_[k]) +
                          bearing_part * std::max(0.0, range2_[k] - sensor2) + surface2;
    if (across2 > trim2 * std::max(rms2, sigma2)) continue;
    members_.push_back(i);
    weights_.push_back(1.0 / sigma2);
  }
}

// Where points fell out, the gap may be one after all: the longest stretch is kept.
void LineExtractor::cut_members_at_gaps(const Line& line) {
  std::size_t best_first = 0, best_count = 0, first = 0;
  const double max_gap2 = square(options_.max_gap_m);
  const auto is_gap_between = [&](int before, int after) {
    const auto a = static_cast<std::size_t>(before), b = static_cast<std::size_t>(after);
    if (b == a + 1 && gap2_[a] <= max_gap2) return false;  // almost all
    const double gap_m = std::abs(line.along_of(x_[b], y_[b]) - line.along_of(x_[a], y_[a]));
    const double reach_m = options_.max_gap_m * static_cast<double>(b - a);
    return b - a > static_cast<std::size_t>(options_.max_outliers_in_a_row) + 1 ||
           (gap_m > reach_m && (b - a > 1 || is_gap_after(before))) ||
           is_opening(before, after, line);
  };
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const bool ends = i + 1 == members_.size() || is_gap_between(members_[i], members_[i + 1]);
    if (!ends) continue;
    if (i + 1 - first > best_count) {
      best_first = first;
      best_count = i + 1 - first;
    }
    first = i + 1;
  }
  if (best_count == members_.size()) return;
  const auto offset = static_cast<std::ptrdiff_t>(best_first);
  std::copy_n(members_.begin() + offset, best_count, members_.begin());
  std::copy_n(weights_.begin() + offset, best_count, weights_.begin());
  members_.resize(best_count);
  weights_.resize(best_count);
}

LineExtractor::Line LineExtractor::fit_members() const {
  Sums sums;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const auto k = static_cast<std::size_t>(members_[i]);
    sums.add_point(x_[k], y_[k], weights_[i]);
  }
  return line_of(sums);
}

void LineExtractor::accept(std::size_t piece_index) {
  const Piece& piece = merged_[piece_index];
  Line line = line_of(sums_of(piece.core_first, piece.core_last));
  if (piece.has_strays()) {
    // A short core points less well than the whole wall: take in all points near it first.
    line.rms_m = options_.split_distance_m;
    choose_members(piece.first, piece.last, line);
    if (static_cast<int>(members_.size()) < options_.min_points) return;
    line = fit_members();
  }
  const int reach = options_.max_outliers_in_a_row;
  const int from =
      std::max(piece_index > 0 ? merged_[piece_index - 1].last + 1 : 0, piece.first - reach);
  const int to = std::min(piece_index + 1 < merged_.size() ? merged_[piece_index + 1].first - 1
                                                           : static_cast<int>(x_.size()) - 1,
                          piece.last + reach);
  for (int round = 0; round < 3; ++round) {
    const std::size_t count_before = members_.size();
    const int first_before = round > 0 ? members_.front() : -1;
    choose_members(std::min(from, piece.first), std::max(to, piece.last), line);
    cut_members_at_gaps(line);
    if (static_cast<int>(members_.size()) < options_.min_points) return;
    const bool same = members_.size() == count_before && members_.front() == first_before;
    line = fit_members();
    if (same) break;
  }
  emit_parts(line);
}

// Two walls a few centimetres apart across, one behind the other along: the split that lowers the
// squared error most, if it does so surely (30 is some five sigma for the two numbers more, and for
// having tried every place) and the two lines are apart there.
// @returns the first member of the second wall, or 0.
std::size_t LineExtractor::step_in_members(const Line& line) const {
  constexpr double kSure = 30.0;
  const std::size_t count = members_.size();
  const auto least = static_cast<std::size_t>(options_.min_points);
  if (count < 2 * least) return 0;
  double chi2 = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(members_[i]);
    chi2 += weights_[i] * square(line.across_of(x_[k], y_[k]));
  }
  // Where the points scatter no more than their sigmas say there is nothing to win.
  if (chi2 < kSure + 0.8 * static_cast<double>(count - 4)) return 0;
  // In the line's own axes along and across are x and y of the sums.
  const auto add = [&](Sums& sums, std::size_t i) {
    const auto k = static_cast<std::size_t>(members_[i]);
    sums.add_point(line.along_of(x_[k], y_[k]), line.across_of(x_[k], y_[k]), weights_[i]);
  };
  const auto rest_of = [](const Sums& sums) {
    const double xx = sums.xx - sums.x * sums.x / sums.weight;
    const double xy = sums.xy - sums.x * sums.y / sums.weight;
    return sums.yy - sums.y * sums.y / sums.weight - xy * xy / std::max(xx, 1e-12);
  };
  const auto at = [](const Sums& sums, double x_m) {
    const double slope = (sums.xy - sums.x * sums.y / sums.weight) /
                         std::max(sums.xx - sums.x * sums.x / sums.weight, 1e-12);
    return sums.y / sums.weight + slope * (x_m - sums.x / sums.weight);
  };
  Sums left, right;
  for (std::size_t i = 0; i < count; ++i) add(right, i);
  const double together = rest_of(right);
  double best = together, step_m = 0.0;
  std::size_t best_split = 0;
  for (std::size_t split = 1; split + least <= count; ++split) {
    Sums moved;
    add(moved, split - 1);
    left.add(moved, 1.0);
    right.add(moved, -1.0);
    if (split < least) continue;
    const double apart = rest_of(left) + rest_of(right);
    if (apart >= best) continue;
    const auto a = static_cast<std::size_t>(members_[split - 1]);
    const auto b = static_cast<std::size_t>(members_[split]);
    const double middle_m = 0.5 * (line.along_of(x_[a], y_[a]) + line.along_of(x_[b], y_[b]));
    best = apart;
    best_split = split;
    step_m = std::abs(at(left, middle_m) - at(right, middle_m));
  }
  const double noise = std::max(1.0, best / static_cast<double>(count - 4));
  return together - best > kSure * noise && step_m > options_.least_step_m ? best_split : 0;
}

void LineExtractor::emit_parts(const Line& line) {
  const std::size_t split = step_in_members(line);
  if (split == 0) return emit(line);
  const auto at = static_cast<std::ptrdiff_t>(split);
  rest_.assign(members_.begin() + at, members_.end());
  rest_weights_.assign(weights_.begin() + at, weights_.end());
  members_.resize(split);
  weights_.resize(split);
  const std::size_t before = walls_.size();
  emit(fit_members());
  members_.swap(rest_);
  weights_.swap(rest_weights_);
  emit(fit_members());
  if (walls_.size() != before + 2) return;
  // The wall in front hides where the other one ends.
  ObservedWall &first = walls_[before], &second = walls_[before + 1];
  const bool second_in_front = first.across().dot(second.center_m - first.center_m) > 0.0;
  (second_in_front ? first.end_seen : second.start_seen) = false;
}

double LineExtractor::spacing_at(std::size_t member, int inwards) const {
  const auto a = static_cast<std::size_t>(members_[member]);
  const auto b = static_cast<std::size_t>(
      members_[static_cast<std::size_t>(static_cast<int>(member) + inwards)]);
  const double beams = std::abs(beam_[b] - beam_[a]);
  return std::hypot(x_[b] - x_[a], y_[b] - y_[a]) / std::max(1.0, beams);
}

void LineExtractor::emit(const Line& fitted) {
  Line line = fitted;
  const auto first = static_cast<std::size_t>(members_.front());
  const auto last = static_cast<std::size_t>(members_.back());
  if (line.along_of(x_[last], y_[last]) < line.along_of(x_[first], y_[first])) {
    line.along_x = -line.along_x;
    line.along_y = -line.along_y;
  }
  const double start_s = line.along_of(x_[first], y_[first]);
  const double end_s = line.along_of(x_[last], y_[last]);
  const double sensor_m = line.across_of(scan_->sensor_m);
  if (end_s - start_s < options_.min_length_m || sensor_m <= 0.0) return;

  double weight = 0.0, spread = 0.0, chi2 = 0.0;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const auto k = static_cast<std::size_t>(members_[i]);
    weight += weights_[i];
    spread += weights_[i] * square(line.along_of(x_[k], y_[k]));
    chi2 += weights_[i] * square(line.across_of(x_[k], y_[k]));
  }
  // A wall rougher than its beams' noise is known less well than they say.
  const double excess = chi2 / static_cast<double>(members_.size() - 2);
  const double scale = excess > 2.0 ? excess : 1.0;
  if (excess > square(options_.max_roughness_sigmas) && end_s - start_s < options_.rough_length_m) {
    return;
  }

  ObservedWall wall;
  wall.center_m = {line.center_x, line.center_y};
  wall.direction_rad = std::atan2(line.along_y, line.along_x);
  const Eigen::Vector2d along(line.along_x, line.along_y);
  wall.start_m = wall.center_m + start_s * along;
  wall.end_m = wall.center_m + end_s * along;
  wall.across_sigma_m = std::sqrt(scale / weight);
  wall.direction_sigma_rad = std::sqrt(scale / spread);
  wall.num_points = static_cast<int>(members_.size());
  wall.first_beam = beam_[first];
  wall.last_beam = beam_[last];
  // A true end lies up to one beam further on, anywhere: half a beam on the average. Without that a
  // wall ahead grows as the robot comes near, and the robot seems to lag behind its wheels.
  const double start_spacing_m = spacing_at(0, 1);
  const double end_spacing_m = spacing_at(members_.size() - 1, -1);
  wall.start_sigma_m = std::hypot(start_spacing_m / std::sqrt(12.0), scan_->range_sigma_m);
  wall.end_sigma_m = std::hypot(end_spacing_m / std::sqrt(12.0), scan_->range_sigma_m);
  wall.start_seen = end_is_seen(wall.first_beam, -1, wall);
  wall.end_seen = end_is_seen(wall.last_beam, 1, wall);
  if (wall.start_seen) wall.start_m -= 0.5 * start_spacing_m * along;
  if (wall.end_seen) wall.end_m += 0.5 * end_spacing_m * along;
  walls_.push_back(wall);
}

// Goes on from the end, beam by beam. A corner: a surface that touches the end leaves the line. An
// edge: the next surface lies behind the line. What lies in front of it and does not touch hides
// the rest; a single echo between the two, as an edge in front makes it, must not pass for a
// corner.
bool LineExtractor::end_is_seen(int beam, int step, const ObservedWall& wall) const {
  constexpr int kLookAhead = 10;
  const double sigma_m = step > 0 ? wall.end_sigma_m : wall.start_sigma_m;
  const double touch_m = std::max(options_.touch_m, 6.0 * sigma_m);
  const Eigen::Vector2d end_m = step > 0 ? wall.end_m : wall.start_m;
  Eigen::Vector2d last_m = end_m;
  for (int ahead = 1; ahead <= kLookAhead; ++ahead) {
    const int next = beam + ahead * step;
    if (next < 0 || next >= static_cast<int>(scan_->beams.size())) return false;
    const Beam& beyond = scan_->beams[static_cast<std::size_t>(next)];
    if (!beyond.returned) return false;
    const double across_m = wall.across().dot(beyond.hit_m - end_m);
    if (across_m < -options_.split_distance_m) return true;
    if ((beyond.hit_m - last_m).squaredNorm() > square(touch_m)) return false;
    if (across_m > 2.0 * options_.split_distance_m) return ahead > 1;
    last_m = beyond.hit_m;
  }
  return false;
}

}  // namespace marco::slam
