// What a guard remembers of the floor. Everything twice: at the origin and far from it, where cells
// have negative numbers.
#include "drivers/base/local_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace marco::drivers {
namespace {

using Ground = LocalMap::Ground;
using End = SeenBeam::End;

class FloorAround : public ::testing::TestWithParam<Eigen::Vector2d> {
 protected:
  Eigen::Vector2d at(double x, double y) const { return GetParam() + Eigen::Vector2d(x, y); }
  Pose2 pose(double x, double y, double theta_rad = 0.0) const {
    return {at(x, y).x(), at(x, y).y(), theta_rad};
  }
  /// 21 beams from -1 to 1 rad, a tenth apart, all of which see nothing as far as they reach.
  std::vector<SeenBeam> beams_from(double x, double y, double z_m = 0.3) const {
    std::vector<SeenBeam> beams;
    for (int i = -10; i <= 10; ++i) beams.push_back(beam(x, y, z_m, 0.1 * i));
    return beams;
  }
  SeenBeam beam(double x, double y, double z_m, double bearing_rad, double down_rad = 0.0) const {
    const Eigen::Vector2d from = at(x, y);
    const double level = std::cos(down_rad);
    return {{from.x(), from.y(), z_m},
            {level * std::cos(bearing_rad), level * std::sin(bearing_rad), -std::sin(down_rad)},
            80.0,
            End::far};
  }
  static void end_at(SeenBeam& beam, double range_m, End end = End::hit) {
    beam.range_m = range_m;
    beam.end = end;
  }
  void see(const std::vector<SeenBeam>& beams) { map_.on_beams(beams, heights_, now_); }
  void wait(double seconds) { now_ = now_ + Duration::from_seconds(seconds); }
  Ground ground(double x, double y) const { return map_.ground_at(at(x, y), now_); }
  std::vector<Eigen::Vector2d> points(double reach_m = 2.0) const {
    return map_.points_about(pose(0.0, 0.0), reach_m, now_);
  }
  /// A point a metre ahead of the origin, seen from there.
  void put_point() {
    auto beams = beams_from(0.0, 0.0);
    end_at(beams[10], 1.0);
    see(beams);
    wait(0.1);
  }
  bool point_stays_after(int scans, const std::vector<SeenBeam>& beams) {
    for (int i = 0; i < scans; ++i) {
      see(beams);
      wait(0.1);
    }
    for (const Eigen::Vector2d& point : points()) {
      if ((point - Eigen::Vector2d(1.0, 0.0)).norm() < 1e-6) return true;
    }
    return false;
  }

  LocalMap map_;
  Heights heights_{0.08, 1.2};
  Utime now_ = Utime::from_seconds(1000.0);
};
INSTANTIATE_TEST_SUITE_P(Places,
                         FloorAround,
                         ::testing::Values(Eigen::Vector2d(0.0, 0.0),
                                           Eigen::Vector2d(-17.3, 9.2),
                                           Eigen::Vector2d(33.1, -21.7)));

TEST_P(FloorAround, IsSeenAsFarAsTheBeamsAreFreeAndNoFartherThanItMatters) {
  auto beams = beams_from(0.0, 0.0);
  for (int i = 5; i <= 15; ++i) end_at(beams[static_cast<std::size_t>(i)], 1.2);
  end_at(beams[1], 80.0, End::no_answer);
  end_at(beams[19], 0.1, End::nothing);
  see(beams);
  EXPECT_EQ(ground(0.9, 0.0), Ground::seen);
  EXPECT_EQ(ground(1.7, 0.0), Ground::unknown) << "behind what they hit";
  EXPECT_EQ(ground(2.3 * std::cos(0.8), 2.3 * std::sin(0.8)), Ground::seen);
  EXPECT_EQ(ground(3.1 * std::cos(0.8), 3.1 * std::sin(0.8)), Ground::unknown);
  EXPECT_EQ(ground(2.3 * std::cos(-0.9), 2.3 * std::sin(-0.9)), Ground::seen) << "no answer";
  EXPECT_EQ(ground(2.3 * std::cos(1.0), 2.3 * std::sin(1.0)), Ground::seen) << "the last one";
  EXPECT_EQ(ground(-0.7, 0.0), Ground::unknown);
  EXPECT_EQ(ground(0.0, -0.7), Ground::unknown);
}

TEST_P(FloorAround, SeenIsNowAndThenRememberedForHalfAMinute) {
  see(beams_from(0.0, 0.0));
  wait(1.4);
  EXPECT_EQ(ground(1.0, 0.0), Ground::seen);
  wait(0.2);
  EXPECT_EQ(ground(1.0, 0.0), Ground::remembered);
  wait(28.0);
  EXPECT_EQ(ground(1.0, 0.0), Ground::remembered);
  wait(1.0);
  EXPECT_EQ(ground(1.0, 0.0), Ground::unknown);
}

// A laser that looks down passes through the body's heights near by alone.
TEST_P(FloorAround, IsSeenByTheBeamAtHeightsThatAreInTheWay) {
  see({beam(0.0, 0.0, 0.5, 0.0, deg_to_rad(30.0))});
  EXPECT_EQ(ground(0.5, 0.0), Ground::seen);  // 21 cm high
  EXPECT_EQ(ground(1.1, 0.0), Ground::unknown);
  see({beam(0.0, 0.0, 1.0, 1.0, std::acos(0.15)), beam(0.0, 0.0, 1.0, -1.0, std::acos(0.3))});
  EXPECT_EQ(ground(0.2 * std::cos(-1.0), 0.2 * std::sin(-1.0)), Ground::seen);
  map_.clear();
  see({beam(0.0, 0.0, 1.0, 1.0, std::acos(0.15))});
  EXPECT_EQ(ground(0.0, 0.0), Ground::unknown) << "so steep it sees nothing of the plan";
}

TEST_P(FloorAround, UnderTheBodyIsRemembered) {
  const Footprint body(Footprint::box(0.30, 0.30, 0.27));
  map_.on_body(body, pose(0.0, 0.0, 0.3), now_);
  EXPECT_EQ(ground(0.0, 0.0), Ground::remembered);
  EXPECT_EQ(ground(0.15, 0.1), Ground::remembered);
  EXPECT_EQ(ground(0.55, 0.0), Ground::unknown);
  EXPECT_EQ(ground(0.0, -0.5), Ground::unknown);
  EXPECT_EQ(ground(-0.55, 0.55), Ground::unknown);
  wait(31.0);
  EXPECT_EQ(ground(0.0, 0.0), Ground::unknown);
}

TEST_P(FloorAround, WhereTheBodyStandsNothingElseDoes) {
  const Footprint body(Footprint::box(0.30, 0.30, 0.27));
  put_point();
  map_.on_body(body, pose(0.68, 0.0), now_);
  EXPECT_EQ(points().size(), 1U) << "2 cm ahead of it";
  map_.on_body(body, pose(0.72, 0.0), now_);
  EXPECT_EQ(points().size(), 1U) << "2 cm in it: the odometry may err so much";
  map_.on_body(body, pose(0.77, 0.0), now_);
  EXPECT_EQ(points().size(), 0U);
}

TEST_P(FloorAround, APointGoesWhenThreeScansPassIt) {
  const auto passing = beams_from(0.0, 0.0);
  put_point();
  EXPECT_TRUE(point_stays_after(2, passing));
  EXPECT_FALSE(point_stays_after(1, passing));
  put_point();
  auto just_behind = beams_from(0.0, 0.0);
  for (SeenBeam& beam : just_behind) end_at(beam, 1.15);
  EXPECT_FALSE(point_stays_after(3, just_behind)) << "of which the next hits are 15 cm behind it";
}

// From elsewhere: where it is seen under 0.3 rad.
TEST_P(FloorAround, APointGoesFromWhereverItIsPassed) {
  for (const double side : {-1.0, 1.0}) {
    put_point();
    EXPECT_FALSE(point_stays_after(3, beams_from(0.0, side * std::tan(0.3))));
  }
  put_point();
  auto other_way_round = beams_from(0.0, std::tan(0.3));
  std::reverse(other_way_round.begin(), other_way_round.end());
  EXPECT_FALSE(point_stays_after(3, other_way_round));
}

TEST_P(FloorAround, APointStaysWhereABeamPassesBesideItOrEndsNearIt) {
  put_point();
  EXPECT_TRUE(point_stays_after(5, beams_from(0.0, 0.015)));
  EXPECT_TRUE(point_stays_after(5, beams_from(0.0, 0.0, 0.38))) << "another height";
  auto near = beams_from(0.0, 0.0);
  for (std::size_t i = 9; i <= 11; ++i) end_at(near[i], 1.07);
  EXPECT_TRUE(point_stays_after(5, near)) << "the same thing, from its other side";
}

TEST_P(FloorAround, APointStaysWhereTheBeamsBesideEndBeforeItOrItsOwnSaysNothing) {
  put_point();
  for (const std::size_t beside : {9, 11}) {
    auto beams = beams_from(0.0, 0.0);
    end_at(beams[beside], 0.8);
    EXPECT_TRUE(point_stays_after(5, beams)) << beside;
  }
  for (const End end : {End::no_answer, End::nothing}) {
    auto beams = beams_from(0.0, 0.0);
    end_at(beams[10], 80.0, end);
    EXPECT_TRUE(point_stays_after(5, beams));
  }
  auto silent_neighbours = beams_from(0.0, 0.0);
  end_at(silent_neighbours[9], 80.0, End::no_answer);
  end_at(silent_neighbours[11], 80.0, End::no_answer);
  EXPECT_FALSE(point_stays_after(3, silent_neighbours)) << "they say neither yes nor no";
}

TEST_P(FloorAround, APointStaysAtTheEdgesOfTheView) {
  for (const bool first : {false, true}) {
    put_point();
    auto beams = beams_from(0.0, 0.0);
    if (first) {
      beams.erase(beams.begin(), beams.begin() + 10);
    } else {
      beams.resize(11);
    }
    EXPECT_TRUE(point_stays_after(5, beams)) << first;
  }
}

TEST_P(FloorAround, OfOneScansHitsInACellTheNearestIsKept) {
  for (const bool nearest_first : {false, true}) {
    map_.clear();
    SeenBeam near = beam(0.0, 0.0, 0.3, 0.0), far = near;
    end_at(near, 1.01);
    end_at(far, 1.02);
    see(nearest_first ? std::vector{near, far} : std::vector{far, near});
    ASSERT_EQ(points().size(), 1U);
    EXPECT_NEAR(points()[0].x(), 1.01, 1e-9);
    wait(0.1);
    see({far});
    EXPECT_NEAR(points()[0].x(), 1.02, 1e-9) << "of a newer scan";
  }
}

TEST_P(FloorAround, PointsBeyondReachOrOutOfTheBodysHeightsAreNotKept) {
  const auto points_of = [&](double range_m, double z_m) {
    map_.clear();
    SeenBeam one = beam(0.0, 0.0, z_m, 0.0);
    end_at(one, range_m);
    see({one});
    return points(3.9).size();
  };
  EXPECT_EQ(points_of(3.3, 0.3), 1U);
  EXPECT_EQ(points_of(3.6, 0.3), 0U);
  EXPECT_EQ(points_of(1.0, 1.3), 0U);
  EXPECT_EQ(points_of(1.0, 0.05), 0U);
}

TEST_P(FloorAround, PointsAreToldInTheRobotsFrameWithinItsReachForHalfAMinute) {
  put_point();
  const auto shown = map_.points_about(pose(0.5, 0.0, 1.0), 1.0, now_);
  ASSERT_EQ(shown.size(), 1U);
  EXPECT_NEAR(shown[0].x(), 0.5 * std::cos(1.0), 1e-9);
  EXPECT_NEAR(shown[0].y(), -0.5 * std::sin(1.0), 1e-9);
  EXPECT_EQ(points(1.0).size(), 1U);
  EXPECT_EQ(points(0.8).size(), 0U);
  EXPECT_EQ(map_.points_about(pose(8.0, 0.0), 3.0, now_).size(), 0U) << "eight metres on";
  EXPECT_EQ(map_.points_about(pose(0.0, -8.0), 3.0, now_).size(), 0U);
  EXPECT_EQ(map_.ground_at(at(8.5, 0.0), now_), Ground::unknown);
  EXPECT_EQ(map_.ground_at(at(0.5, 8.0), now_), Ground::unknown);
  wait(29.0);
  EXPECT_EQ(points().size(), 1U);
  wait(2.0);
  EXPECT_EQ(points().size(), 0U);
}

TEST_P(FloorAround, ARayOfASonarSeesItsWay) {
  map_.on_ray(at(0.2, 0.1), at(1.4, 0.1), now_);
  EXPECT_EQ(ground(0.3, 0.1), Ground::seen);
  EXPECT_EQ(ground(1.2, 0.1), Ground::seen);
  EXPECT_EQ(ground(1.9, 0.1), Ground::unknown);
  EXPECT_EQ(ground(-0.4, 0.1), Ground::unknown);
  EXPECT_EQ(ground(0.8, 0.6), Ground::unknown);
  map_.on_ray(at(0.2, -1.0), at(3.8, -1.0), now_);
  EXPECT_EQ(ground(2.5, -1.0), Ground::seen);
  EXPECT_EQ(ground(3.2, -1.0), Ground::unknown) << "no farther than it matters";
}

}  // namespace
}  // namespace marco::drivers
