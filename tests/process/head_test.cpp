// marco-head against a pan-tilt on the network.
#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>

#include "common/pose2.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"

namespace marco {
namespace {

using ::marco::testing::Program;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;

// Turns by 6 degrees a state, and pans to 90 degrees at most.
class HeadCommand : public ::testing::Test {
 protected:
  HeadCommand() : bus_("") {
    bus_.subscribe<pantilt_command_t>(
        channels::kPanTiltCommand, heard_,
        [this](const auto& message, const auto&) { orders_.push_back(from_message(message)); });
  }
  // @returns the exit code of `marco head` with these words; `obeys` is whether anything answers
  int head(std::vector<std::string> words, bool obeys = true, int interrupt_after = 1000) {
    Program program("marco-head", std::move(words), at("head.out"));
    for (int state = 0; state < 200; ++state) {
      if (const int code = program.wait(0.03); code != -1) return code;
      while (bus_.handle_once(0)) {
      }
      if (obeys) tell();
      if (state == interrupt_after) program.signal(SIGINT);
    }
    return -1;
  }
  void tell() {
    if (!orders_.empty() && orders_.back().kind == PanTiltCommand::Kind::go_to) {
      const double limit_rad = deg_to_rad(90.0), step_rad = deg_to_rad(6.0);
      const PanTiltCommand& order = orders_.back();
      const double pan_rad = std::clamp(order.pan_rad, -limit_rad, limit_rad);
      now_.pan_rad += std::clamp(pan_rad - now_.pan_rad, -step_rad, step_rad);
      now_.tilt_rad += std::clamp(order.tilt_rad - now_.tilt_rad, -step_rad, step_rad);
    }
    now_.utime = Utime::from_us(process::wall_clock_us());
    bus_.publish(channels::kPanTiltState, to_message(now_));
  }
  std::string at(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string said() const { return files::read_whole_file(at("head.out")); }

  process::LcmBus bus_;
  process::DropCounter heard_;
  TemporaryFolder folder_;
  std::vector<PanTiltCommand> orders_;
  PanTiltState now_;
};

TEST_F(HeadCommand, PointsThePanTiltAndSaysWhereItStands) {
  EXPECT_EQ(head({"30", "-10"}), 0) << said();
  EXPECT_THAT(said(), HasSubstr("there: pan 30.0, tilt -10.0 degrees"));
  ASSERT_EQ(orders_.size(), 1U);
  EXPECT_NEAR(orders_[0].pan_rad, deg_to_rad(30.0), 1e-12);
  EXPECT_NEAR(orders_[0].tilt_rad, deg_to_rad(-10.0), 1e-12);
  EXPECT_EQ(head({"120", "0"}), 1);
  EXPECT_THAT(said(),
              HasSubstr("it stands at pan 90.0, tilt 0.0 degrees: it cannot reach farther"));
}

TEST_F(HeadCommand, SaysWhenNobodyAnswersAndStopsWhenItIsStopped) {
  EXPECT_EQ(head({"30", "0"}, false), 1);
  EXPECT_THAT(said(), HasSubstr("no pan-tilt reports its angles"));
  EXPECT_EQ(head({"90", "0"}, true, 3), 128 + SIGINT);
  while (bus_.handle_once(100)) {
  }
  EXPECT_EQ(orders_.back().kind, PanTiltCommand::Kind::stop);
  EXPECT_EQ(head({"30"}), 2);
  EXPECT_EQ(head({"400", "0"}), 2);
}

}  // namespace
}  // namespace marco
