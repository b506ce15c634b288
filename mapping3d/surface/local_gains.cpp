#include "mapping3d/surface/local_gains.hpp"

#include <algorithm>

namespace marco::mapping3d {
namespace {

// 30 cm: what is smaller is detail. Larger cubes leave steps where light changes faster, smaller
// ones take a pattern that two pictures show 2 pixels apart for a difference of light.
constexpr float kPointsPerEdge = 6.0F;
constexpr float kSmallestGain = 0.4F, kLargestGain = 2.5F;  // light changes by no more than a stop
constexpr float kPriorLevels = 20.0F;  // pulls to 1 like one point of this value

}  // namespace

LocalGains::Key LocalGains::key_of(const Eigen::Vector3i& cell, int facing) {
  constexpr int kBits = 20;  // +-2^19 cubes of 0.3 m: 157 km
  Key key = static_cast<Key>(facing);
  for (int i = 0; i < 3; ++i) {
    key = key << kBits | (static_cast<Key>(cell[i]) & ((Key{1} << kBits) - 1));
  }
  return key;
}

template <class Visit>
void LocalGains::for_each_corner(const Eigen::Vector3f& point_m, const Visit& visit) const {
  const Eigen::Vector3f scaled = point_m / edge_m_;
  const Eigen::Vector3f low = scaled.array().floor();
  const Eigen::Vector3f part = scaled - low;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i step(corner & 1, corner >> 1 & 1, corner >> 2);
    float weight = 1.0F;
    for (int i = 0; i < 3; ++i) weight *= step[i] == 1 ? part[i] : 1.0F - part[i];
    visit(corner, low.cast<int>() + step, weight);
  }
}

LocalGains::LocalGains(const SurfaceLooks& seen) : edge_m_(kPointsPerEdge * seen.apart_m) {
  for (const SurfaceLooks::Point& point : seen.points) add(point, seen.of(point));
  for (Cube& cube : cubes_) {
    cube.reached = cube.weight > 0.0F;
    if (cube.reached) cube.colour /= cube.weight;
  }
  fill();
}

void LocalGains::add(const SurfaceLooks::Point& point, std::span<const Look> looks) {
  const bool agreed = vote(looks, shares_);  // from contradictions nothing is learned
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  float sum = 0.0F;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    mean += shares_[i] * looks[i].merit * looks[i].rgb;
    sum += shares_[i] * looks[i].merit;
  }
  const bool counts = agreed && sum > 0.0F;
  if (counts) mean /= sum;
  for_each_corner(point.at_m, [&](int, const Eigen::Vector3i& cell, float weight) {
    const auto [entry, is_new] =
        cube_of_.try_emplace(key_of(cell, point.facing), static_cast<int>(cubes_.size()));
    if (is_new) {
      cubes_.emplace_back();
      cells_.emplace_back(cell, point.facing);
    }
    if (!counts) return;
    Cube& cube = cubes_[static_cast<std::size_t>(entry->second)];
    cube.colour += weight * mean;
    cube.weight += weight;
    for (std::size_t i = 0; i < looks.size(); ++i) {
      auto of_view = std::find_if(cube.views.begin(), cube.views.end(),
                                  [&](const OfView& other) { return other.view == looks[i].view; });
      if (of_view == cube.views.end()) {
        cube.views.push_back({looks[i].view});
        of_view = std::prev(cube.views.end());
      }
      of_view->wanted += weight * shares_[i] * mean;
      of_view->shown += weight * shares_[i] * looks[i].rgb;
    }
  });
}

std::vector<std::size_t> LocalGains::neighbours(std::size_t cube) const {
  std::vector<std::size_t> found;
  const auto& [cell, facing] = cells_[cube];
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i step(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (step.isZero()) continue;
    const auto entry = cube_of_.find(key_of(cell + step, facing));
    if (entry != cube_of_.end()) found.push_back(static_cast<std::size_t>(entry->second));
  }
  return found;
}

Eigen::Vector3f LocalGains::mean_colour(int facing) const {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float weight = 0.0F;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (facing >= 0 && cells_[i].second != facing) continue;
    sum += cubes_[i].weight * cubes_[i].colour;
    weight += cubes_[i].weight;
  }
  constexpr float kGrey = 128.0F;  // where no picture sees anything
  if (weight > 0.0F) return sum / weight;
  return facing >= 0 ? mean_colour(-1) : Eigen::Vector3f::Constant(kGrey);
}

Eigen::Vector3f LocalGains::mean_around(std::size_t cube) const {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  int number = 0;
  for (const std::size_t other : neighbours(cube)) {
    if (!cubes_[other].reached) continue;
    sum += cubes_[other].colour;
    ++number;
  }
  return number > 0 ? Eigen::Vector3f(sum / static_cast<float>(number)) : cubes_[cube].colour;
}

// Outwards, a ring of cubes at a time.
std::vector<std::size_t> LocalGains::spread() {
  std::vector<std::size_t> filled, ring;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (cubes_[i].reached) ring.push_back(i);
  }
  while (!ring.empty()) {
    std::vector<std::size_t> next;
    for (const std::size_t cube : ring) {
      for (const std::size_t other : neighbours(cube)) {
        if (!cubes_[other].reached) next.push_back(other);
      }
    }
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    for (const std::size_t cube : next) cubes_[cube].colour = mean_around(cube);
    for (const std::size_t cube : next) cubes_[cube].reached = true;
    filled.insert(filled.end(), next.begin(), next.end());
    ring = std::move(next);
  }
  return filled;
}

void LocalGains::fill() {
  const std::vector<std::size_t> filled = spread();
  constexpr int kSweeps = 20;  // of Gauss and Seidel's relaxation: smooths over six metres
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (const std::size_t cube : filled) cubes_[cube].colour = mean_around(cube);
  }
  std::array<Eigen::Vector3f, 6> means;
  for (int facing = 0; facing < 6; ++facing) {
    means[static_cast<std::size_t>(facing)] = mean_colour(facing);
  }
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (!cubes_[i].reached) cubes_[i].colour = means[static_cast<std::size_t>(cells_[i].second)];
  }
}

LocalGains::Place LocalGains::at(const Eigen::Vector3f& point_m, int facing) const {
  Place place;
  place.field_ = this;
  for_each_corner(point_m, [&](int corner, const Eigen::Vector3i& cell, float weight) {
    const auto entry = cube_of_.find(key_of(cell, facing));
    const auto i = static_cast<std::size_t>(corner);
    place.cubes_[i] = entry == cube_of_.end() ? -1 : entry->second;
    place.weights_[i] = weight;
  });
  return place;
}

Eigen::Vector3f LocalGains::Place::gain(uint32_t view) const {
  Eigen::Vector3f wanted = Eigen::Vector3f::Constant(kPriorLevels), shown = wanted;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (cubes_[i] < 0) continue;
    for (const OfView& of_view : field_->cubes_[static_cast<std::size_t>(cubes_[i])].views) {
      if (of_view.view != view) continue;
      wanted += weights_[i] * of_view.wanted;
      shown += weights_[i] * of_view.shown;
      break;
    }
  }
  return wanted.cwiseQuotient(shown).cwiseMax(kSmallestGain).cwiseMin(kLargestGain);
}

bool LocalGains::Place::reached() const {
  return std::all_of(cubes_.begin(), cubes_.end(), [&](int cube) {
    return cube < 0 || field_->cubes_[static_cast<std::size_t>(cube)].reached;
  });
}

Eigen::Vector3f LocalGains::Place::colour() const {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float weight = 0.0F;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (cubes_[i] < 0) continue;
    sum += weights_[i] * field_->cubes_[static_cast<std::size_t>(cubes_[i])].colour;
    weight += weights_[i];
  }
  return weight > 0.0F ? Eigen::Vector3f(sum / weight) : field_->mean_colour(-1);
}

}  // namespace marco::mapping3d
