#include "mapping3d/scene_overlaps.hpp"

#include <gmock/gmock.h>

#include <random>

namespace marco::mapping3d {
namespace {

std::vector<std::pair<std::size_t, std::size_t>> overlaps_of(
    const std::vector<std::vector<Surfel>>& sets, std::size_t min_shared) {
  std::vector<const std::vector<Surfel>*> all;
  for (const auto& set : sets) all.push_back(&set);
  return find_overlaps(all, min_shared);
}

TEST(FindOverlaps, AreThoseThatShareSurfels) {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> somewhere(0.1, 0.9);
  const auto wall_at = [&](double x_m, double facing, std::size_t count) {
    std::vector<Surfel> surfels(count);
    for (Surfel& surfel : surfels) {
      surfel.center_m = {x_m, somewhere(random), somewhere(random)};
      surfel.normal = {facing, 0.0, 0.0};
    }
    return surfels;
  };
  const std::vector<std::vector<Surfel>> sets{wall_at(0.5, 1.0, 20), wall_at(0.6, 1.0, 10),
                                              wall_at(0.5, -1.0, 20), wall_at(3.5, 1.0, 20)};
  EXPECT_THAT(overlaps_of(sets, 10), ::testing::ElementsAre(std::pair(0U, 1U)));
  EXPECT_THAT(overlaps_of(sets, 11), ::testing::IsEmpty());
}

// Everybody sees the same hall: each keeps its strongest partners.
TEST(FindOverlaps, GrowWithTheNumberOfSets) {
  std::vector<std::vector<Surfel>> sets;
  for (std::size_t i = 0; i < 60; ++i) {
    Surfel surfel{};
    surfel.center_m = {0.5, 0.5, 0.5};
    surfel.normal = {0.0, 0.0, 1.0};
    sets.emplace_back(30, surfel);
  }
  EXPECT_LE(overlaps_of(sets, 10).size(), 8U * sets.size());
}

}  // namespace
}  // namespace marco::mapping3d
