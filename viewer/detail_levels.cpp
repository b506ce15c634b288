#include "viewer/detail_levels.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace marco::viewer {
namespace {

constexpr float kPart_m = 2.0F;
constexpr std::array<float, 4> kErrors_m{0.003F, 0.01F, 0.03F, 0.1F};
// A level that spares less is not worth its place.
constexpr double kWorthwhile = 0.7;

Eigen::Vector3f position(const Geometry& surfaces, uint32_t index) {
  return Eigen::Vector3f(surfaces.vertices[index].position_m.data());
}

// A box lies outside when all its corners lie beyond one side of the clip space.
bool may_be_seen(const Eigen::Matrix4d& clip_from_world,
                 const Eigen::Vector3d& low_m,
                 const Eigen::Vector3d& high_m) {
  std::array<int, 6> outside{};
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d at((corner & 1) != 0 ? high_m.x() : low_m.x(),
                             (corner & 2) != 0 ? high_m.y() : low_m.y(),
                             (corner & 4) != 0 ? high_m.z() : low_m.z());
    const Eigen::Vector4d clip = clip_from_world * at.homogeneous();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double value = clip[static_cast<Eigen::Index>(axis)];
      outside[2 * axis] += value > clip.w() ? 1 : 0;
      outside[2 * axis + 1] += value < -clip.w() ? 1 : 0;
    }
  }
  return *std::max_element(outside.begin(), outside.end()) < 8;
}

}  // namespace

DetailLevels::DetailLevels(const Geometry& surfaces) {
  std::map<std::array<int, 3>, std::vector<uint32_t>> cells;
  for (std::size_t i = 0; i + 2 < surfaces.indices.size(); i += 3) {
    const uint32_t* corner = &surfaces.indices[i];
    const Eigen::Vector3f middle = (position(surfaces, corner[0]) + position(surfaces, corner[1]) +
                                    position(surfaces, corner[2])) /
                                   (3.0F * kPart_m);
    std::vector<uint32_t>& cell =
        cells[{static_cast<int>(std::floor(middle.x())), static_cast<int>(std::floor(middle.y())),
               static_cast<int>(std::floor(middle.z()))}];
    cell.insert(cell.end(), corner, corner + 3);
  }
  for (auto& [place, triangles] : cells) add_part(surfaces, std::move(triangles));
}

void DetailLevels::add_part(const Geometry& surfaces, std::vector<uint32_t> triangles) {
  Part part{position(surfaces, triangles[0]).cast<double>(),
            position(surfaces, triangles[0]).cast<double>(),
            {}};
  // The library's time goes with the vertices it is shown, so that it gets the part's own.
  std::map<uint32_t, uint32_t> own;
  std::vector<uint32_t> all_of_own, local;
  std::vector<float> places;
  for (const uint32_t index : triangles) {
    const Eigen::Vector3d at = position(surfaces, index).cast<double>();
    part.low_m = part.low_m.cwiseMin(at);
    part.high_m = part.high_m.cwiseMax(at);
    const auto [found, fresh] = own.try_emplace(index, static_cast<uint32_t>(own.size()));
    if (fresh) {
      all_of_own.push_back(index);
      const auto& p = surfaces.vertices[index].position_m;
      places.insert(places.end(), p.begin(), p.end());
    }
    local.push_back(found->second);
  }
  const auto keep = [&](const std::vector<uint32_t>& level, double error_m) {
    part.levels.push_back({{indices_.size(), level.size()}, error_m});
    for (const uint32_t index : level) indices_.push_back(all_of_own[index]);
  };
  keep(local, 0.0);
  const float extent_m =
      std::max(1e-6F, meshopt_simplifyScale(places.data(), own.size(), 3 * sizeof(float)));
  std::vector<uint32_t> last = std::move(local);
  for (const float error_m : kErrors_m) {
    std::vector<uint32_t> fewer(last.size());
    fewer.resize(meshopt_simplify(fewer.data(), last.data(), last.size(), places.data(), own.size(),
                                  3 * sizeof(float), 0, error_m / extent_m,
                                  meshopt_SimplifyLockBorder, nullptr));
    if (static_cast<double>(fewer.size()) > kWorthwhile * static_cast<double>(last.size()))
      continue;
    // Each level is made from the one before: their errors add up.
    keep(fewer, part.levels.back().error_m + static_cast<double>(error_m));
    last = std::move(fewer);
  }
  parts_.push_back(std::move(part));
}

std::vector<DetailLevels::Range> DetailLevels::choose(const Eigen::Matrix4d& clip_from_world,
                                                      const Eigen::Vector3d& eye_m,
                                                      double px_per_m,
                                                      bool perspective,
                                                      double allowed_px) const {
  std::vector<Range> chosen;
  for (const Part& part : parts_) {
    if (!may_be_seen(clip_from_world, part.low_m, part.high_m)) continue;
    const Eigen::Vector3d nearest_m = eye_m.cwiseMax(part.low_m).cwiseMin(part.high_m);
    const double distance_m = perspective ? (nearest_m - eye_m).norm() : 1.0;
    const Level* best = &part.levels.front();
    for (const Level& level : part.levels) {
      if (level.error_m * px_per_m <= allowed_px * distance_m) best = &level;
    }
    chosen.push_back(best->range);
  }
  return chosen;
}

}  // namespace marco::viewer
