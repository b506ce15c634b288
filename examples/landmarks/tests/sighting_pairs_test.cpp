#include <gtest/gtest.h>

#include <random>

#include "landmarks/sighting_association.hpp"
#include "landmarks/sighting_correlation.hpp"
#include "landmarks/visibility.hpp"

namespace marco::slam {
namespace {

constexpr SightingNoise kSightingNoise{0.03, 0.02, 0.02, 0.03};

PointFilter with_posts(const std::vector<Sighting>& posts) {
  PointFilter filter({});
  for (const Sighting& post : posts) filter.add(post, kSightingNoise);
  return filter;
}

TEST(SightingAssociation, PairsOneToOne) {
  const PointFilter filter = with_posts({{2.0, 0.0}, {2.0, 0.2}});
  const auto matches =
      associate_sightings(filter, {{2.0, 0.19}, {2.0, 0.01}}, kSightingNoise, 0.99);
  EXPECT_EQ(matches[0].landmark, 1);
  EXPECT_EQ(matches[1].landmark, 0);
}

TEST(SightingAssociation, LeavesOutWhatCouldBeEitherOfTwo) {
  const PointFilter filter = with_posts({{2.0, 0.0}, {2.0, 0.06}});
  const auto matches = associate_sightings(filter, {{2.0, 0.03}}, kSightingNoise, 0.99);
  EXPECT_EQ(matches[0].landmark, SightingMatch::kUnclear);
}

TEST(SightingAssociation, ASightingFarFromAllIsNewOneNearByIsUnclear) {
  const PointFilter filter = with_posts({{2.0, 0.0}});
  const auto far = associate_sightings(filter, {{3.5, 0.5}}, kSightingNoise, 0.99);
  EXPECT_EQ(far[0].landmark, SightingMatch::kNew);
  const auto near = associate_sightings(filter, {{2.17, 0.0}}, kSightingNoise, 0.99);
  EXPECT_EQ(near[0].landmark, SightingMatch::kUnclear);
}

TEST(SightingCorrelation, IndependentSightingsCountInFull) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  SightingCorrelation correlation;
  for (int i = 0; i < 20000; ++i) correlation.add(1, {normal(random), normal(random)}, i);
  EXPECT_NEAR(correlation.noise_factor(), 1.0, 0.2);
}

TEST(SightingCorrelation, RepeatedErrorsCountLess) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  SightingCorrelation correlation;
  Eigen::Vector2d shared(0, 0);
  for (int i = 0; i < 20000; ++i) {
    // Ten sightings in a row have one error: the factor is 10.
    if (i % 10 == 0) shared = {normal(random), normal(random)};
    correlation.add(1, shared, i);
  }
  EXPECT_NEAR(correlation.noise_factor(), 10.0, 2.0);
}

TEST(Visibility, LearnsHowOftenAndHowFar) {
  Visibility visibility;
  visibility.add_scan({{5.0, -1.0}, {2.0, 1.0}});
  EXPECT_EQ(visibility.probability(4.9, 0.0), 0.0);
  EXPECT_EQ(visibility.probability(2.0, 1.5), 0.0);
  for (int i = 0; i < 100; ++i) visibility.vote(2.0, i % 4 != 0);
  EXPECT_NEAR(visibility.probability(2.0, 0.0), 0.75, 0.02);
  EXPECT_NEAR(visibility.probability(4.0, 0.0), 0.5, 0.01);
}

}  // namespace
}  // namespace marco::slam
