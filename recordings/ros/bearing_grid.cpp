#include "recordings/ros/bearing_grid.hpp"

#include <algorithm>
#include <cmath>

#include "common/median.hpp"

namespace marco::ros {
namespace {

constexpr std::size_t kFewest = 20;  // points that tell a step
constexpr double kMostSteps = 20000.0;

double bearing_of(const Eigen::Vector3f& point) {
  return std::atan2(static_cast<double>(point.y()), static_cast<double>(point.x()));
}

// Most beams have a neighbour.
double middle_step_rad(const CloudMessage& cloud) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < cloud.points.size(); ++i) {
    steps.push_back(std::abs(bearing_of(cloud.points[i]) - bearing_of(cloud.points[i - 1])));
  }
  return median(std::move(steps));
}

}  // namespace

void BearingGrid::add(const CloudMessage& cloud) {
  const bool is_first = fullest_ == 0;
  for (const Eigen::Vector3f& point : cloud.points) {
    const double bearing_rad = bearing_of(point);
    const bool begins = is_first && &point == &cloud.points.front();
    least_rad_ = begins ? bearing_rad : std::min(least_rad_, bearing_rad);
    most_rad_ = begins ? bearing_rad : std::max(most_rad_, bearing_rad);
  }
  if (cloud.points.size() >= kFewest && cloud.points.size() > fullest_) {
    told_step_rad_ = middle_step_rad(cloud);
  }
  fullest_ = std::max(fullest_, cloud.points.size());
}

double BearingGrid::step_rad() const {
  if (!(told_step_rad_ > 0.0)) return 0.0;
  const double steps = std::round((most_rad_ - least_rad_) / told_step_rad_);
  return steps < 1.0 || steps > kMostSteps ? 0.0 : (most_rad_ - least_rad_) / steps;
}

std::vector<float> BearingGrid::ranges_m(const CloudMessage& cloud) const {
  constexpr double kBetween = 0.2;
  const double step = step_rad();
  if (!(step > 0.0)) return {};
  std::vector<float> ranges_m(
      static_cast<std::size_t>(std::llround((most_rad_ - least_rad_) / step)) + 1, 0.0F);
  for (const Eigen::Vector3f& point : cloud.points) {
    const double column = (bearing_of(point) - least_rad_) / step;
    const double nearest = std::round(column);
    const bool is_on_beam = std::abs(column - nearest) < kBetween && nearest >= 0.0 &&
                            nearest < static_cast<double>(ranges_m.size());
    if (!is_on_beam) return {};
    ranges_m[static_cast<std::size_t>(nearest)] = point.head<2>().norm();
  }
  return ranges_m;
}

}  // namespace marco::ros
