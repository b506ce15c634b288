#include "web/steering.hpp"

#include <gmock/gmock.h>

namespace marco::web {
namespace {

using Kind = BaseCommand::Kind;

Utime at(double s) { return Utime::from_us(1'700'000'000'000'000 + std::llround(1e6 * s)); }

class SteeringOfTwo : public ::testing::Test {
 protected:
  Steering steering_{SteeringOptions{}};
};

TEST_F(SteeringOfTwo, PassesTheNewestVelocityOn) {
  EXPECT_FALSE(steering_.due(at(0)));
  steering_.drive(1, {0.1, 0.2}, at(0));
  steering_.drive(1, {0.2, -0.3}, at(0.001));
  const auto sent = steering_.due(at(0.002));
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->kind, Kind::velocity);
  EXPECT_EQ(sent->velocity_m_per_s, 0.2);
  EXPECT_EQ(sent->yaw_rate_rad_per_s, -0.3);
  EXPECT_EQ(sent->utime, at(0.002));
  EXPECT_FALSE(steering_.due(at(0.5)));  // once: who wants to go on says so again
}

TEST_F(SteeringOfTwo, PassesAtMostTwentyASecondOn) {
  int sent = 0;
  for (int i = 0; i < 1000; ++i) {
    steering_.drive(1, {0.1, 0.0}, at(1e-3 * i));
    if (steering_.due(at(1e-3 * i))) ++sent;
  }
  EXPECT_EQ(sent, 20);
}

TEST_F(SteeringOfTwo, IsNoFasterThanTheLimits) {
  steering_.drive(1, {-7.0, 100.0}, at(0));
  const auto sent = steering_.due(at(0));
  EXPECT_EQ(sent->velocity_m_per_s, -SteeringOptions{}.most_velocity_m_per_s);
  EXPECT_NEAR(sent->yaw_rate_rad_per_s, deg_to_rad(60.0), 1e-9);
}

TEST_F(SteeringOfTwo, StopsWhenTheStickIsLetGo) {
  steering_.drive(1, {0.1, 0.0}, at(0));
  steering_.due(at(0));
  steering_.drive(1, {0.0, 0.0}, at(0.01));
  EXPECT_EQ(steering_.due(at(0.01))->kind, Kind::stop);  // at once
  // A stick that rests ends nobody's goal.
  steering_.drive(1, {0.0, 0.0}, at(0.2));
  steering_.drive(2, {0.0, 0.0}, at(0.2));
  EXPECT_FALSE(steering_.due(at(0.2)));
}

TEST_F(SteeringOfTwo, LetsOneDriveAtATime) {
  steering_.drive(1, {0.1, 0.0}, at(0));
  EXPECT_THROW(steering_.drive(2, {0.1, 0.0}, at(0.4)), std::invalid_argument);
  steering_.drive(2, {0.1, 0.0}, at(0.51));
  EXPECT_THROW(steering_.drive(1, {0.1, 0.0}, at(0.6)), std::invalid_argument);
}

TEST_F(SteeringOfTwo, StopsWhenTheDriverIsGone) {
  steering_.drive(1, {0.1, 0.0}, at(0));
  steering_.due(at(0));
  steering_.forget(2, at(0.1));
  EXPECT_FALSE(steering_.due(at(0.1)));
  steering_.forget(1, at(0.1));
  EXPECT_EQ(steering_.due(at(0.1))->kind, Kind::stop);
}

TEST_F(SteeringOfTwo, AStickThatIsLetGoWaitsForNothing) {
  steering_.drive(1, {0.1, 0.0}, at(0));
  steering_.let_go();
  EXPECT_FALSE(steering_.due(at(0.1)));
  steering_.drive(2, {0.1, 0.0}, at(0.1));
  EXPECT_TRUE(steering_.due(at(0.1)));
}

TEST(Twists, AreReadWithAndWithoutAStamp) {
  const auto plain = parse_twist(R"({"linear":{"x":0.5,"y":9},"angular":{"z":-1}})");
  EXPECT_EQ(plain.m_per_s, 0.5);
  EXPECT_EQ(plain.rad_per_s, -1.0);
  EXPECT_EQ(parse_twist(R"({"header":{},"twist":{"linear":{"x":2}}})").m_per_s, 2.0);
  for (const char* text : {"", "[]", "{}", R"({"linear":{"x":"1"}})", R"({"linear":{"x":1e400}})",
                           R"({"linear":7})"}) {
    EXPECT_THROW(parse_twist(text), std::invalid_argument) << text;
  }
}

TEST(Poses, AreReadWithAndWithoutCovariance) {
  const auto goal =
      parse_pose(R"({"header":{"frame_id":"/odom"},"pose":{"position":{"x":1,"y":2,"z":0},)"
                 R"("orientation":{"x":0,"y":0,"z":1,"w":1}}})");
  EXPECT_EQ(goal.frame, "odom");
  EXPECT_EQ(goal.pose.x_m, 1.0);
  EXPECT_NEAR(goal.pose.theta_rad, std::numbers::pi / 2, 1e-9);
  const auto pose = parse_pose(R"({"pose":{"pose":{"position":{"x":3}},"covariance":[]}})");
  EXPECT_EQ(pose.frame, "map");
  EXPECT_EQ(pose.pose.x_m, 3.0);
  EXPECT_EQ(pose.pose.theta_rad, 0.0);
  EXPECT_THROW(parse_pose(R"({"header":{"frame_id":"camera"},"pose":{"position":{}}})"),
               std::invalid_argument);
  EXPECT_THROW(parse_pose(R"({"pose":{}})"), std::invalid_argument);
}

}  // namespace
}  // namespace marco::web
