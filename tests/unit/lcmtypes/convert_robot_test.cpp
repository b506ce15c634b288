#include "lcmtypes/convert_robot.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace marco {
namespace {

TEST(ConvertRobot, AnEmergencyStopHoldsWhateverItsStampAReleaseDoesNot) {
  const EmergencyStop back =
      from_message(to_message(EmergencyStop{Utime::from_us(INT64_MIN), true, "", ""}));
  EXPECT_TRUE(back.engaged);
  EXPECT_EQ(back.utime, Utime::from_us(INT64_MIN));
  EXPECT_THROW(from_message(to_message(EmergencyStop{Utime::from_us(INT64_MIN), false, "", ""})),
               std::invalid_argument);
}

TEST(ConvertRobot, RefusesWhatCannotBe) {
  base_command_t command = to_message(BaseCommand{});
  command.kind = 17;
  EXPECT_THROW(from_message(command), std::invalid_argument);
  command = to_message(BaseCommand{});
  command.velocity_m_per_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(from_message(command), std::invalid_argument);
  SonarRing ring;
  ring.readings.push_back({std::numeric_limits<double>::infinity(), {}});
  EXPECT_THROW(from_message(to_message(ring)), std::invalid_argument);
}

}  // namespace
}  // namespace marco
