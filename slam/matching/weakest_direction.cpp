#include "slam/matching/weakest_direction.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {

WeakestDirection::WeakestDirection(const Eigen::Matrix3d& sum) {
  const double turn = sum(2, 2) > 0.0 ? 1.0 / sum(2, 2) : 0.0;
  const double xx = sum(0, 0) - turn * sum(0, 2) * sum(0, 2);
  const double xy = sum(0, 1) - turn * sum(0, 2) * sum(1, 2);
  const double yy = sum(1, 1) - turn * sum(1, 2) * sum(1, 2);
  information = std::max(0.0, 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy));
  const double angle = 0.5 * std::atan2(-2.0 * xy, yy - xx);
  direction = {std::cos(angle), std::sin(angle)};
  const double x = direction.x(), y = direction.y();
  const double along = x * x * sum(1, 1) - 2.0 * x * y * sum(0, 1) + y * y * sum(0, 0);
  by_noise = std::min(information, kNormalSigma * kNormalSigma * along);
}

}  // namespace marco::slam
