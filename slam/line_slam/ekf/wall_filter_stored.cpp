// The filter as values that can be written down, and back.
#include <algorithm>

#include "lcm_tools/base/check.hpp"
#include "slam/line_slam/ekf/wall_filter.hpp"

namespace marco::slam {

WallFilter::Stored WallFilter::store() {
  std::vector<int> all = blocks();
  Stored stored;
  stored.has_mark = mark_ > 0;
  if (stored.has_mark) all.push_back(mark_);
  for (const int block : state_.active().subspan(1)) {
    const auto at = std::find(all.begin(), all.end(), block);
    stored.active.push_back(static_cast<int32_t>(at - all.begin()));
  }
  stored.covariance = state_.dense_covariance(all);
  state_.catch_up(state_.num_tiles());
  stored.mean = state_.dense_mean(all);
  stored.first_estimate.resize(stored.mean.size());
  stored.first_estimate.head<3>() = state_.first_estimate(0).head<3>();
  for (std::size_t k = 0; k < all.size(); ++k) {
    stored.first_estimate.segment<4>(3 + 4 * static_cast<Eigen::Index>(k)) =
        state_.first_estimate(all[k]);
  }
  stored.walls = walls_;
  stored.moved_since_focus_m = moved_since_focus_m_;
  stored.next_id = next_id_;
  return stored;
}

void WallFilter::restore(const Stored& stored) {
  const std::size_t count = stored.walls.size() + (stored.has_mark ? 1 : 0);
  const auto size = static_cast<Eigen::Index>(3 + 4 * count);
  require(stored.mean.size() == size && stored.first_estimate.size() == size &&
              stored.covariance.rows() == size && stored.covariance.cols() == size,
          "wall_filter: stored sizes do not agree");
  require(
      stored.mean.allFinite() && stored.first_estimate.allFinite() && stored.covariance.allFinite(),
      "wall_filter: stored values are not finite");
  std::vector<char> is_active(count, 0);
  for (const int32_t index : stored.active) {
    const bool known = index >= 0 && static_cast<std::size_t>(index) < count;
    require(known && is_active[static_cast<std::size_t>(index)] == 0,
            "wall_filter: stored active part names no wall, or one twice");
    is_active[static_cast<std::size_t>(index)] = 1;
  }
  state_ = CompressedState(stored.mean.head<3>(), stored.covariance.topLeftCorner<3, 3>());
  walls_ = stored.walls;
  next_id_ = stored.next_id;
  std::vector<int> all;
  for (std::size_t k = 0; k < count; ++k) {
    all.push_back(state_.append(Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero(),
                                Eigen::Matrix<double, 4, 3>::Zero(), Eigen::Matrix4d::Zero()));
    if (k < walls_.size()) walls_[k].block = all.back();
  }
  mark_ = stored.has_mark ? all.back() : 0;
  state_.restore(all, stored.mean, stored.first_estimate, stored.covariance);
  std::vector<int> active;
  for (const int32_t index : stored.active) active.push_back(all[static_cast<std::size_t>(index)]);
  state_.activate(active);
  moved_since_focus_m_ = stored.moved_since_focus_m;
}

}  // namespace marco::slam
