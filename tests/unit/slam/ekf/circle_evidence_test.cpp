#include "slam/line_slam/ekf/circle_evidence.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace marco::slam {
namespace {

constexpr double kPi = std::numbers::pi;
const WallEvidenceOptions kArcOptions;

TEST(SeenArc, GrowsTheShorterWayAndClosesToACircle) {
  SeenArc arc(kArcOptions, 3.0, 0.5, 2.0);
  arc.grow(-3.0, 0.4);  // begins at 3.283: a gap of turn 0.783 - 0.5 after its end
  EXPECT_NEAR(arc.from_rad, 3.0, 1e-12);
  EXPECT_NEAR(arc.span_rad, 2.0 * kPi - 6.0 + 0.4, 1e-12);
  arc.grow(2.0, 0.7);  // before it
  EXPECT_NEAR(arc.from_rad, 2.0, 1e-12);
  EXPECT_NEAR(arc.span_rad, 1.0 + 2.0 * kPi - 6.0 + 0.4, 1e-12);
  arc.grow(2.2, 0.1);  // within it
  EXPECT_NEAR(arc.from_rad, 2.0, 1e-12);
  arc.grow(-2.9, 2.0 * kPi - 1.2);
  EXPECT_NEAR(arc.span_rad, 2.0 * kPi, 1e-12);
}

TEST(SeenArc, StandsWhereItWasSeenOnly) {
  SeenArc arc(kArcOptions, 0.0, 1.0, 3.0);
  const SeenArc other(kArcOptions, 2.0, 1.0, 3.0);
  arc.merge(other);
  const auto pieces = arc.standing(3.0, kArcOptions);
  ASSERT_EQ(pieces.size(), 2U);
  const double bin_rad = kArcOptions.bin_m / 3.0;
  EXPECT_NEAR(pieces[0].span_rad, 1.0, bin_rad);
  EXPECT_NEAR(pieces[1].from_rad, 2.0, bin_rad);
  EXPECT_NEAR(pieces[1].span_rad, 1.0, bin_rad);
  // A post is drawn whole.
  EXPECT_EQ(SeenArc(kArcOptions, 0.0, 1.0, 0.1).standing(0.1, kArcOptions).at(0).span_rad,
            2.0 * kPi);
}

TEST(SeenArc, ARunAcrossItsBeginningIsOnePiece) {
  SeenArc arc(kArcOptions, 1.0, 2.0 * kPi, 3.0);
  ScanInRobot scan;  // rays to direction pi from the centre see through it
  for (int i = -20; i <= 20; ++i) {
    const double bearing = kPi + 0.01 * i;
    scan.beams.push_back({{8.0 * std::cos(bearing), 8.0 * std::sin(bearing)}, 8.0, true});
  }
  for (int k = 0; k < 3; ++k) {
    arc.vote_by_rays(scan, {}, {0, 0, 3}, true, 0.0);
    arc.evidence.count_votes(kArcOptions);
  }
  const auto pieces = arc.standing(3.0, kArcOptions);
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_NEAR(pieces[0].span_rad, 2.0 * kPi - 0.4, 2.0 * kArcOptions.bin_m / 3.0);
}

}  // namespace
}  // namespace marco::slam
