#include "common/pose_buffer.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace marco {
namespace {

using ::marco::testing::IsNear;

Utime at_ms(int64_t ms) { return Utime::from_us(1000 * ms); }

TEST(PoseBuffer, InterpolatesBetweenSamplesAndKnowsNothingOutside) {
  PoseBuffer buffer;
  EXPECT_FALSE(buffer.at(at_ms(0)));
  buffer.add(at_ms(100), {0, 0, 0});
  buffer.add(at_ms(200), {1, 0, 0.2});
  EXPECT_THAT(*buffer.at(at_ms(125)), IsNear(Pose2{0.25, 0, 0.05}, 1e-12, 1e-12));
  EXPECT_FALSE(buffer.at(at_ms(99)));
  EXPECT_FALSE(buffer.at(at_ms(201)));
}

TEST(PoseBuffer, ExtrapolatesWithTheLastVelocityWithinReach) {
  PoseBuffer buffer;
  buffer.add(at_ms(100), {0, 0, 0});
  buffer.add(at_ms(200), {1, 0, 0});
  EXPECT_THAT(*buffer.at(at_ms(250), Duration::from_seconds(0.1)),
              IsNear(Pose2{1.5, 0, 0}, 1e-12, 1e-12));
  EXPECT_FALSE(buffer.at(at_ms(301), Duration::from_seconds(0.1)));
}

// A stalled logger writes two samples within a microsecond: 1 mm in it is no 1000 m/s.
TEST(PoseBuffer, ExtrapolatesNoFurtherThanTheTimeThatItsVelocityIsOf) {
  PoseBuffer buffer;
  buffer.add(at_ms(100), {0, 0, 0});
  buffer.add(at_ms(100) + Duration{1}, {0.001, 0, 0});
  EXPECT_THAT(*buffer.at(at_ms(150), Duration::from_seconds(0.1)),
              IsNear(Pose2{0.002, 0, 0}, 1e-12, 1e-12));
  buffer.add(at_ms(200), {1, 0, 0});
  buffer.add(at_ms(200) + Duration{1}, {1.001, 0, 0});
  EXPECT_THAT(*buffer.at(at_ms(250), Duration::from_seconds(0.1)),
              IsNear(Pose2{1.501, 0, 0}, 1e-3, 1e-12));
}

TEST(PoseBuffer, AStampThatStepsBackwardsStillAnswersExactly) {
  PoseBuffer buffer;
  buffer.add(at_ms(100), {1, 0, 0});
  buffer.add(at_ms(900), {9, 0, 0});
  buffer.add(at_ms(200), {2, 0, 0});
  EXPECT_THAT(*buffer.at(at_ms(200)), IsNear(Pose2{2, 0, 0}, 0, 0));
  EXPECT_EQ(buffer.newest(), at_ms(200));
}

TEST(PoseBuffer, MotionOfAScanThatIsNotOverYetIsTheLastKnownOfItsLength) {
  PoseBuffer buffer;
  const Duration length = Duration::from_seconds(0.2);
  EXPECT_FALSE(buffer.motion_during(at_ms(100), length));
  for (const int ms : {0, 100, 200, 300}) buffer.add(at_ms(ms), {1e-5 * ms * ms, 0, 0});
  EXPECT_THAT(*buffer.motion_during(at_ms(50), length), IsNear(Pose2{0.6, 0, 0}, 1e-12, 0));
  EXPECT_THAT(*buffer.motion_during(at_ms(250), length), IsNear(Pose2{0.8, 0, 0}, 1e-12, 0));
  EXPECT_FALSE(buffer.motion_during(at_ms(501), length)) << "too old";
  EXPECT_FALSE(buffer.motion_during(at_ms(-1), length)) << "before the first";
  EXPECT_THAT(*buffer.motion_during(at_ms(100), Duration{}), IsNear(Pose2{}, 0, 0));
}

TEST(PoseBuffer, ForgetsTheOldestBeyondItsCapacity) {
  PoseBuffer buffer(3);
  for (int i = 0; i < 5; ++i) buffer.add(at_ms(100 * i), {1.0 * i, 0, 0});
  EXPECT_EQ(buffer.oldest(), at_ms(200));
  EXPECT_THROW(PoseBuffer(1), std::invalid_argument);
}

}  // namespace
}  // namespace marco
