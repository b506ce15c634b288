#include "plan/free_space.hpp"

#include <algorithm>
#include <cmath>

#include "common/median.hpp"

namespace marco::plan {
namespace {

constexpr double kFarthestM = 12.0;  // beams lie too far apart there
constexpr double kBeforeHitM = 0.06;

}  // namespace

FreeSpace::FreeSpace(const std::vector<slam::Keyframe>& keys, const Pose2& plan_from_map) {
  Eigen::Vector2d high(0, 0);
  bool first = true;
  for (const slam::Keyframe& key : keys) {
    const Pose2 pose = plan_from_map * key.world_from_robot;
    const Eigen::Vector2d at = pose * key.sensor_in_robot;
    double reach = 0;
    const Points2& points = key.points_in_robot.points;
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      reach = std::max(reach, (points.col(i) - key.sensor_in_robot).norm());
    }
    reach = std::min(reach, kFarthestM) + 0.5;
    const Eigen::Vector2d reaches(reach, reach);
    low_ = first ? at - reaches : Eigen::Vector2d(low_.cwiseMin(at - reaches));
    high = first ? at + reaches : Eigen::Vector2d(high.cwiseMax(at + reaches));
    first = false;
  }
  low_ = ((low_.array() / kCellM).floor() - 2) * kCellM;
  width_ = static_cast<int>((high.x() - low_.x()) / kCellM) + 4;
  height_ = static_cast<int>((high.y() - low_.y()) / kCellM) + 4;
  const std::size_t cells = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  free_.assign(cells, 0);
  through_.assign(cells, 0);
  stopped_.assign(cells, 0);
  last_.assign(cells, -1);
  for (std::size_t k = 0; k < keys.size(); ++k) {
    look(keys[k], plan_from_map * keys[k].world_from_robot, static_cast<int>(k));
  }
  for (std::size_t i = 0; i < cells; ++i) {
    free_[i] = through_[i] >= 2 && through_[i] > 3 * stopped_[i];
  }
}

int FreeSpace::cell_of(const Eigen::Vector2d& point) const {
  const int x = static_cast<int>(std::floor((point.x() - low_.x()) / kCellM));
  const int y = static_cast<int>(std::floor((point.y() - low_.y()) / kCellM));
  return x < 0 || y < 0 || x >= width_ || y >= height_ ? -1 : y * width_ + x;
}

Eigen::Vector2d FreeSpace::centre_of(int cell) const {
  return low_ + kCellM * Eigen::Vector2d(cell % width_ + 0.5, cell / width_ + 0.5);
}

void FreeSpace::close(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const double length = (to - from).norm();
  const Eigen::Vector2d way = (to - from) / std::max(length, 1e-9);
  const Eigen::Vector2d across(-way.y(), way.x());
  for (double s = 0; s <= length; s += 0.5 * kCellM) {
    for (const double t : {-0.5 * kCellM, 0.0, 0.5 * kCellM}) {
      const int cell = cell_of(from + way * s + across * t);
      if (cell >= 0) free_[static_cast<std::size_t>(cell)] = 0;
    }
  }
}

// Morphological opening by a square: erosion, then dilation, along x and along y.
void FreeSpace::smooth() {
  constexpr int kHalf = 2;  // cells: what is narrower than 25 cm is no room, nor a way into one
  const int cells = width_ * height_;
  const auto pass = [&](int step, uint8_t spreading) {
    const std::vector<uint8_t> before = free_;
    for (int cell = 0; cell < cells; ++cell) {
      for (int k = -kHalf; k <= kHalf; ++k) {
        const int at = cell + k * step;
        if (at < 0 || at >= cells) continue;
        if (before[static_cast<std::size_t>(at)] == spreading)
          free_[static_cast<std::size_t>(cell)] = spreading;
      }
    }
  };
  for (const uint8_t spreading : {uint8_t{0}, uint8_t{1}}) {
    pass(1, spreading);
    pass(width_, spreading);
  }
}

bool FreeSpace::is_hit(int cell) const {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int at = cell + dy * width_ + dx;
      if (at >= 0 && at < width_ * height_ && stopped_[static_cast<std::size_t>(at)] > 0) {
        return true;
      }
    }
  }
  return false;
}

// Between two neighbouring beams the space is free up to the nearer hit.
void FreeSpace::look(const slam::Keyframe& key, const Pose2& plan_from_robot, int stamp) {
  const Eigen::Vector2d sensor = plan_from_robot * key.sensor_in_robot;
  const Points2 hits = plan_from_robot * key.points_in_robot.points;
  struct Beam {
    double angle_rad, range_m;
  };
  std::vector<Beam> beams;
  for (Eigen::Index i = 0; i < hits.cols(); ++i) {
    const Eigen::Vector2d ray = hits.col(i) - sensor;
    beams.push_back({std::atan2(ray.y(), ray.x()), ray.norm()});
    const int cell = cell_of(hits.col(i));
    if (cell >= 0) ++stopped_[static_cast<std::size_t>(cell)];
  }
  if (beams.size() < 3) return;
  std::sort(beams.begin(), beams.end(),
            [](const Beam& a, const Beam& b) { return a.angle_rad < b.angle_rad; });
  std::vector<double> steps;
  for (std::size_t i = 1; i < beams.size(); ++i) {
    steps.push_back(beams[i].angle_rad - beams[i - 1].angle_rad);
  }
  const double widest = 1.6 * std::max(median(std::move(steps)), 1e-3);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Beam& one = beams[i];
    const Beam& next = beams[(i + 1) % beams.size()];
    const double turn = normalize_angle(next.angle_rad - one.angle_rad);
    if (turn < 0 || turn > widest) continue;
    const double range = std::min({one.range_m, next.range_m, kFarthestM}) - kBeforeHitM;
    const int rays = std::max(1, static_cast<int>(std::ceil(turn * range / (0.7 * kCellM))));
    for (int ray = 0; ray <= rays; ++ray) {
      const double angle = one.angle_rad + turn * ray / rays;
      const Eigen::Vector2d way(std::cos(angle), std::sin(angle));
      for (double at = 0; at < range; at += 0.7 * kCellM) {
        const int cell = cell_of(sensor + way * at);
        if (cell < 0 || last_[static_cast<std::size_t>(cell)] == stamp) continue;
        last_[static_cast<std::size_t>(cell)] = stamp;
        ++through_[static_cast<std::size_t>(cell)];
      }
    }
  }
}

}  // namespace marco::plan
