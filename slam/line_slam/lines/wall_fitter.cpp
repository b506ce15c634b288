#include "slam/line_slam/lines/wall_fitter.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {

void WallFitter::fit(const ScanPoints& points,
                     const std::vector<LinePiece>& pieces,
                     std::size_t index,
                     std::vector<ObservedWall>& walls) {
  points_ = &points;
  const LinePiece& piece = pieces[index];
  FittedLine line = fit_line(points.sums_of(piece.core_first, piece.core_last));
  const auto too_few = [this] { return static_cast<int>(members_.size()) < options_.min_points; };
  if (piece.has_outliers()) {
    // A short core gives a poorer direction than the whole wall: take in all points near it first.
    line.rms_m = options_.split_distance_m;
    choose_members(piece.first, piece.last, line);
    if (too_few()) return;
    line = fit_members();
  }
  const int reach = options_.max_outliers_in_a_row;
  const int from = std::max(index > 0 ? pieces[index - 1].last + 1 : 0, piece.first - reach);
  const int to =
      std::min(index + 1 < pieces.size() ? pieces[index + 1].first - 1 : points.size() - 1,
               piece.last + reach);
  for (int round = 0; round < 3; ++round) {
    const std::size_t count_before = members_.size();
    const int first_before = round > 0 ? members_.front().point : -1;
    choose_members(std::min(from, piece.first), std::max(to, piece.last), line);
    cut_members_at_gaps(line);
    if (too_few()) return;
    const bool same = members_.size() == count_before && members_.front().point == first_before;
    line = fit_members();
    if (same) break;
  }
  add_parts(line, walls);
}

// Variance of a point across its line: the range's error where the beam meets the wall head on, the
// bearing's where it grazes it.
void WallFitter::choose_members(int from, int to, const FittedLine& line) {
  const ScanInRobot& scan = points_->scan();
  const double rms2 = std::min(square(line.rms_m), square(0.5 * options_.split_distance_m));
  const double limit2 = square(options_.split_distance_m);
  const double sensor2 = square(line.across_of(scan.sensor_m));
  const double range_part = square(scan.range_sigma_m) * sensor2;
  const double bearing_part = square(scan.bearing_sigma_rad);
  const double surface2 = square(options_.surface_sigma_m), trim2 = square(options_.trim_sigmas);
  members_.clear();
  for (int i = from; i <= to; ++i) {
    const double across2 = square(points_->across_of(line, i));
    if (across2 > limit2) continue;
    const double sigma2 =
        std::min(square(scan.range_sigma_m), range_part * points_->inverse_range2(i)) +
        bearing_part * std::max(0.0, points_->range2(i) - sensor2) + surface2;
    if (across2 > trim2 * std::max(rms2, sigma2)) continue;
    members_.push_back({i, 1.0 / sigma2});
  }
}

bool WallFitter::is_gap_between(int before, int after, const FittedLine& line) const {
  const int skipped = after - before - 1;
  if (skipped == 0 && points_->gap2(before) <= square(options_.max_gap_m)) return false;
  const double gap_m = std::abs(points_->along_of(line, after) - points_->along_of(line, before));
  const double reach_m = options_.max_gap_m * static_cast<double>(after - before);
  return skipped > options_.max_outliers_in_a_row ||
         (gap_m > reach_m && (skipped > 0 || points_->is_gap_after(before))) ||
         points_->is_opening(before, after, line);
}

// Leaving points out may open a gap: the longest part is kept.
void WallFitter::cut_members_at_gaps(const FittedLine& line) {
  std::size_t best_first = 0, best_count = 0, first = 0;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const bool ends =
        i + 1 == members_.size() || is_gap_between(members_[i].point, members_[i + 1].point, line);
    if (!ends) continue;
    if (i + 1 - first > best_count) {
      best_first = first;
      best_count = i + 1 - first;
    }
    first = i + 1;
  }
  if (best_count == members_.size()) return;
  std::copy_n(members_.begin() + static_cast<std::ptrdiff_t>(best_first), best_count,
              members_.begin());
  members_.resize(best_count);
}

FittedLine WallFitter::fit_members() const {
  LineSums sums;
  for (const Member& member : members_) {
    sums.add_point(points_->x(member.point), points_->y(member.point), member.weight);
  }
  return fit_line(sums);
}

double WallFitter::chi2_of(const FittedLine& line) const {
  double chi2 = 0.0;
  for (const Member& member : members_) {
    chi2 += member.weight * square(points_->across_of(line, member.point));
  }
  return chi2;
}

// Two walls a few centimetres apart across, one behind the other along: the split that lowers the
// squared error most, if it is significant and the two lines are apart there.
// @returns the first member of the second wall, or 0.
std::size_t WallFitter::find_step(const FittedLine& line) const {
  // About five sigma for two more parameters and for trying every place.
  constexpr double kSignificant = 30.0;
  const std::size_t count = members_.size();
  const auto least = static_cast<std::size_t>(options_.min_points);
  if (count < 2 * least) return 0;
  // Points that scatter no more than their sigmas say leave nothing to gain.
  if (chi2_of(line) < kSignificant + 0.8 * static_cast<double>(count - 4)) return 0;
  // In the line's own axes: x along, y across.
  const auto add = [&](LineSums& sums, const Member& member) {
    sums.add_point(points_->along_of(line, member.point), points_->across_of(line, member.point),
                   member.weight);
  };
  LineSums left, right;
  for (const Member& member : members_) add(right, member);
  const double together = right.regression_residual();
  double best = together, step_m = 0.0;
  std::size_t best_split = 0;
  for (std::size_t split = 1; split + least <= count; ++split) {
    LineSums moved;
    add(moved, members_[split - 1]);
    left.add(moved, 1.0);
    right.add(moved, -1.0);
    if (split < least) continue;
    const double apart = left.regression_residual() + right.regression_residual();
    if (apart >= best) continue;
    const double middle_m = 0.5 * (points_->along_of(line, members_[split - 1].point) +
                                   points_->along_of(line, members_[split].point));
    best = apart;
    best_split = split;
    step_m = std::abs(left.regression_at(middle_m) - right.regression_at(middle_m));
  }
  const double noise = std::max(1.0, best / static_cast<double>(count - 4));
  return together - best > kSignificant * noise && step_m > options_.least_step_m ? best_split : 0;
}

void WallFitter::add_parts(const FittedLine& line, std::vector<ObservedWall>& walls) {
  const std::size_t split = find_step(line);
  if (split == 0) return add_wall(line, walls);
  rest_.assign(members_.begin() + static_cast<std::ptrdiff_t>(split), members_.end());
  members_.resize(split);
  const std::size_t before = walls.size();
  add_wall(fit_members(), walls);
  members_.swap(rest_);
  add_wall(fit_members(), walls);
  if (walls.size() != before + 2) return;
  // The wall in front hides the end of the other one.
  ObservedWall &first = walls[before], &second = walls[before + 1];
  const bool second_in_front = first.across().dot(second.center_m - first.center_m) > 0.0;
  (second_in_front ? first.end_seen : second.start_seen) = false;
}

// Distance between neighbouring beams on the wall.
double WallFitter::spacing_m(const Member& at, const Member& inwards) const {
  const double beams = std::abs(points_->beam(inwards.point) - points_->beam(at.point));
  return std::hypot(points_->x(inwards.point) - points_->x(at.point),
                    points_->y(inwards.point) - points_->y(at.point)) /
         std::max(1.0, beams);
}

void WallFitter::add_wall(const FittedLine& fitted, std::vector<ObservedWall>& walls) const {
  const ScanInRobot& scan = points_->scan();
  FittedLine line = fitted;
  const int first = members_.front().point, last = members_.back().point;
  if (points_->along_of(line, last) < points_->along_of(line, first)) {
    line.along_x = -line.along_x;
    line.along_y = -line.along_y;
  }
  const double start_s = points_->along_of(line, first), end_s = points_->along_of(line, last);
  const double length_m = end_s - start_s;
  if (length_m < options_.min_length_m || line.across_of(scan.sensor_m) <= 0.0) return;

  double weight = 0.0, spread = 0.0;
  for (const Member& member : members_) {
    weight += member.weight;
    spread += member.weight * square(points_->along_of(line, member.point));
  }
  // A wall rougher than its beams' noise is known less well than the beams say.
  const double excess = chi2_of(line) / static_cast<double>(members_.size() - 2);
  const double scale = excess > 2.0 ? excess : 1.0;
  if (excess > square(options_.max_roughness_sigmas) && length_m < options_.rough_length_m) return;

  ObservedWall wall;
  wall.center_m = {line.center_x, line.center_y};
  wall.direction_rad = std::atan2(line.along_y, line.along_x);
  const Eigen::Vector2d along(line.along_x, line.along_y);
  wall.start_m = wall.center_m + start_s * along;
  wall.end_m = wall.center_m + end_s * along;
  wall.across_sigma_m = std::sqrt(scale / weight);
  wall.direction_sigma_rad = std::sqrt(scale / spread);
  wall.num_points = static_cast<int>(members_.size());
  wall.first_beam = points_->beam(first);
  wall.last_beam = points_->beam(last);
  // The true end lies up to one beam farther on, half a beam on average. Without this correction a
  // wall ahead grows as the robot approaches, and the robot seems to lag behind its odometry.
  const double start_spacing_m = spacing_m(members_[0], members_[1]);
  const double end_spacing_m = spacing_m(members_.back(), members_[members_.size() - 2]);
  wall.start_sigma_m = std::hypot(start_spacing_m / std::sqrt(12.0), scan.range_sigma_m);
  wall.end_sigma_m = std::hypot(end_spacing_m / std::sqrt(12.0), scan.range_sigma_m);
  wall.start_seen = end_is_seen(wall.first_beam, -1, wall);
  wall.end_seen = end_is_seen(wall.last_beam, 1, wall);
  if (wall.start_seen) wall.start_m -= 0.5 * start_spacing_m * along;
  if (wall.end_seen) wall.end_m += 0.5 * end_spacing_m * along;
  walls.push_back(wall);
}

// Looks beam by beam beyond the end. A corner: a surface that touches the end leaves the line. An
// edge: the next surface lies behind the line. A surface in front that does not touch hides the
// rest of the wall; a single echo between the two, as edges in front cause, is not a corner.
bool WallFitter::end_is_seen(int beam, int step, const ObservedWall& wall) const {
  constexpr int kLookAhead = 10;  // beams: what touches the end begins within them
  const ScanInRobot& scan = points_->scan();
  const double sigma_m = step > 0 ? wall.end_sigma_m : wall.start_sigma_m;
  const double touch_m = std::max(options_.touch_m, 6.0 * sigma_m);
  const Eigen::Vector2d end_m = step > 0 ? wall.end_m : wall.start_m;
  Eigen::Vector2d last_m = end_m;
  for (int ahead = 1; ahead <= kLookAhead; ++ahead) {
    const int next = beam + ahead * step;
    if (next < 0 || next >= static_cast<int>(scan.beams.size())) return false;
    const Beam& beyond = scan.beams[static_cast<std::size_t>(next)];
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
