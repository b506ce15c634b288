#include "mapping3d/scene_overlaps.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

namespace marco::mapping3d {
namespace {

// Wider than any error of a path within a building.
constexpr double kCubeM = 1.0;

// A stop in an open hall sees dozens of others. These tie it to the rest: ten stops in ten rooms
// of an office have 3 to 6.
constexpr std::size_t kPartners = 8;

using CubeSide = std::array<int, 4>;  // a cube, and which of six ways a surfel faces

CubeSide side_of(const Surfel& surfel) {
  Eigen::Index axis = 0;
  surfel.normal.cwiseAbs().maxCoeff(&axis);
  const int facing = 2 * static_cast<int>(axis) + (surfel.normal[axis] > 0.0 ? 1 : 0);
  const Eigen::Array3i cube = (surfel.center_m.array() / kCubeM).floor().cast<int>();
  return {cube.x(), cube.y(), cube.z(), facing};
}

struct Partner {
  std::size_t shared, set;
};

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> find_overlaps(
    const std::vector<const std::vector<Surfel>*>& sets, std::size_t min_shared) {
  std::map<CubeSide, std::map<std::size_t, std::size_t>> seen;  // surfels of each set
  for (std::size_t set = 0; set < sets.size(); ++set) {
    for (const Surfel& surfel : *sets[set]) ++seen[side_of(surfel)][set];
  }
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> shared;
  for (const auto& [side, counts] : seen) {
    for (auto a = counts.begin(); a != counts.end(); ++a) {
      for (auto b = std::next(a); b != counts.end(); ++b) {
        shared[{a->first, b->first}] += std::min(a->second, b->second);
      }
    }
  }
  std::vector<std::vector<Partner>> partners(sets.size());
  for (const auto& [pair, count] : shared) {
    if (count < min_shared) continue;
    partners[pair.first].push_back({count, pair.second});
    partners[pair.second].push_back({count, pair.first});
  }
  std::set<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t set = 0; set < sets.size(); ++set) {
    std::stable_sort(partners[set].begin(), partners[set].end(),
                     [](const Partner& a, const Partner& b) { return a.shared > b.shared; });
    partners[set].resize(std::min(partners[set].size(), kPartners));
    for (const Partner& partner : partners[set]) pairs.insert(std::minmax(set, partner.set));
  }
  return {pairs.begin(), pairs.end()};
}

}  // namespace marco::mapping3d
