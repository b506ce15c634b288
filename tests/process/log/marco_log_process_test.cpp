// marco-log and marco-spy with what Marco adds to them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "lcm_tools/tests/support/log_command.hpp"
#include "lcm_tools/tests/unit/log/tiny_log.hpp"

namespace marco::logs {
namespace {

using ::testing::HasSubstr;
using testing::log_program;
using testing::Outcome;
using testing::run;
using testing::run_log;

TEST(Cli, ALogOfAnotherKindIsPointedToImport) {
  const ScratchFolder folder;
  write_text(folder / "a.log",
             "FLASER 3 1.0 2.0 3.0 0 0 0 0 0 0 1.5 host 1.5\n"
             "FLASER 3 1.0 2.0 3.0 0 0 0 0 0 0 1.6 host 1.6\n");
  write_poses(folder / "log", 5);
  const std::string log = folder / "a.log", out = folder / "out";
  for (const std::string& arguments :
       {"cut " + log + " " + out, "filter " + log + " " + out + " -c LIDAR",
        "merge " + (folder / "log") + " " + log + " -o " + out, "repair " + log + " " + out,
        "export " + log + " " + out + " --format jsonl", "play " + log}) {
    const Outcome outcome = run_log(arguments);
    EXPECT_EQ(outcome.exit_code, 1) << arguments;
    EXPECT_THAT(outcome.output, HasSubstr("is not an LCM log but a CARMEN log; `marco log import " +
                                          log + " OUT.lcm` converts it"))
        << arguments;
    EXPECT_FALSE(std::filesystem::exists(out)) << arguments;
  }
  const Outcome info = run_log("info " + log);
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.output, HasSubstr("CARMEN log"));
  EXPECT_THAT(info.output, ::testing::ContainsRegex("scan +2 +10\\.00"));
  EXPECT_EQ(run_log("import " + log + " " + out).exit_code, 0);
  for (const auto& [ending, format] : {std::pair(".bag", "ROS bag"), std::pair(".mcap", "MCAP")}) {
    const std::string recording = folder / ("ros" + std::string(ending));
    ASSERT_EQ(run_log("convert " + out + " " + recording).exit_code, 0);
    const Outcome of_ros = run_log("info " + recording);
    EXPECT_EQ(of_ros.exit_code, 0) << of_ros.output;
    EXPECT_THAT(of_ros.output, HasSubstr(format));
    EXPECT_THAT(of_ros.output,
                ::testing::ContainsRegex("/scan +sensor_msgs/LaserScan +[a-z0-9]+ +2 "));
  }
  write_text(folder / "text", "no log");
  const Outcome refused = run_log("import " + (folder / "text") + " " + (folder / "none"));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.output, HasSubstr("known inputs"));
  EXPECT_FALSE(std::filesystem::exists(folder / "none"));
  EXPECT_THAT(run(std::string(std::getenv("MARCO_BIN")) + "/marco-spy --once " + log).output,
              HasSubstr("is not an LCM log but a CARMEN log"));
}

TEST(Cli, MarcosTypesFormatsAndOrdersAreKnown) {
  const ScratchFolder folder;
  write_poses(folder / "log", 50);
  {
    files::EventLogWriter writer(folder / "orders");
    writer.write("BASE_COMMAND", pose_bytes(kStartUs, 0), Utime::from_us(kStartUs));
    writer.write("EMERGENCY_STOP", pose_bytes(kStartUs, 0), Utime::from_us(kStartUs));
  }
  const auto works = [&](const std::string& arguments, const std::string& says) {
    const Outcome outcome = run_log(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr(says)) << arguments;
  };
  works("info " + (folder / "log"), "marco.pose2_t");
  works("export " + (folder / "log") + " " + (folder / "out.mcap"), "100 messages on 4 topics");
  const Outcome no_laser = run_log("export " + (folder / "log") + " " + (folder / "out.carmen"));
  EXPECT_EQ(no_laser.exit_code, 1);
  EXPECT_THAT(no_laser.output, HasSubstr("no laser among its channels: OTHER"));
  works("play --speed 0 " + (folder / "orders"),
        "left out 2 orders that a live robot would obey: 1 on BASE_COMMAND, 1 on EMERGENCY_STOP");
}

TEST(Spy, TellsHowToStartARobotWhenNothingIsHeard) {
  const Outcome silent =
      run(std::string(std::getenv("MARCO_BIN")) + "/marco-spy --once --duration 0.1");
  EXPECT_THAT(silent.output, HasSubstr("./marco run config/sim.procman drive"));
}

TEST(Mcap, IsReadByTheFormatsOwnLibrary) {
  const ScratchFolder folder;
  write_poses(folder / "log", 9000);
  const std::string check =
      "node " + std::filesystem::absolute("lcm_tools/tests/process/log/mcap_check.cjs").string() +
      " ";
  if (run("node --version").exit_code != 0 || run(check + "/dev/null").exit_code == 77) {
    std::puts("SKIPPED: no node, or no @mcap/core where NODE_PATH says");
    return;
  }
  ASSERT_EQ(run_log("export " + (folder / "log") + " " + (folder / "out.mcap")).exit_code, 0);
  const Outcome outcome = run(check + (folder / "out.mcap"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("\"TRUE_POSE\":4500"));
  EXPECT_THAT(outcome.output, HasSubstr("\"OTHER/PoseInFrame\":4500"));
  EXPECT_THAT(outcome.output, HasSubstr("\"streamed\":18000,\"whole\":true"));
  EXPECT_THAT(outcome.output, HasSubstr("foxglove.PoseInFrame"));
}

}  // namespace
}  // namespace marco::logs
