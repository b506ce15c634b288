#include "slam/line_slam/ekf/ray_votes.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/lines_world.hpp"

namespace marco::slam {
namespace {

const WallEvidenceOptions kOptions;

double standing_m(const WallEvidence& evidence) {
  double length_m = 0.0;
  for (const WallEvidence::Run& run : evidence.runs(kOptions)) length_m += run.to_m - run.from_m;
  return length_m;
}

// A wall 4 m long, seen from 2 m in front of it, and what was drawn beside it.
class RayVotesTest : public ::testing::Test {
 protected:
  RayVotesTest() {
    world_.edges.push_back({{2.0, -2.0}, {2.0, 2.0}});
    world_.edges.push_back({{2.5, 4.0}, {2.5, -4.0}});
  }
  void look(int scans) {
    for (int i = 0; i < scans; ++i) {
      const auto taken = testing::take_scan(world_, testing::LinesLaser{}, {}, random_);
      vote_for_nearest(taken.scan,
                       {{{2.0, 2.0, 2.0, -2.0}, &true_wall_}, {rival_in_robot_, &rival_}});
      true_wall_.count_votes(kOptions);
      rival_.count_votes(kOptions);
    }
  }
  testing::LinesWorld world_;
  std::mt19937 random_{5};
  Eigen::Vector4d rival_in_robot_;
  WallEvidence true_wall_{kOptions, 4.0}, rival_{kOptions, 4.0};
};

TEST_F(RayVotesTest, OfTwoWallsThatFaceTheSameWayTheNearerStands) {
  rival_in_robot_ = {2.05, 2.0, 2.06, -2.0};
  look(10);
  EXPECT_GT(standing_m(true_wall_), 3.7);
  EXPECT_LT(standing_m(rival_), 0.3);
}

TEST_F(RayVotesTest, AWallThatFacesAnotherWayIsNoRival) {
  rival_in_robot_ = {2.0, -2.0, 6.0, -2.0};  // meets the first one at its end
  look(10);
  EXPECT_GT(standing_m(true_wall_), 3.7);
}

TEST_F(RayVotesTest, WhatRaysWentThroughFalls) {
  rival_in_robot_ = {1.0, 1.5, 1.0, -1.5};
  rival_ = WallEvidence(kOptions, 3.0);
  look(10);
  EXPECT_EQ(standing_m(rival_), 0.0);
}

TEST(WallEvidence, ForgetsAllButThatAPieceWasSeen) {
  WallEvidence evidence(kOptions, 1.0);
  for (int i = 0; i < 20; ++i) {
    evidence.vote_hit(0.25);
    evidence.vote_passed(0.75);
    evidence.count_votes(kOptions);
  }
  evidence.forget(kOptions);
  evidence.vote_passed(0.25);
  evidence.count_votes(kOptions);
  EXPECT_DOUBLE_EQ(standing_m(evidence), 0.8) << "all but the piece passed now, and the other one";
}

}  // namespace
}  // namespace marco::slam
