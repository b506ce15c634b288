#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <thread>

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/messages.hpp"
#include "lcm_tools/tests/process/procman/procman_bench.hpp"
#include "procman_lcm/output_t.hpp"

namespace marco::procman {
namespace {

using testing::HasSubstr;
using testing::Not;

const char* const kRobot = R"(
group "g" {
  cmd "a" { exec = "bash -c 'echo from a; sleep 1000'"; deputy = "bench"; }
  cmd "b" { exec = "sleep 1000"; deputy = "bench"; }
}
cmd "c" { exec = "sleep 1000"; deputy = "bench"; }
script "go" { start group "g" wait "running"; run_script "deeper"; stop cmd "b" wait "stopped"; }
script "deeper" { start cmd "c" wait "running"; wait ms 50; run_script "deepest"; }
script "deepest" { restart cmd "c" wait "running"; }
script "for ever" { run_script "deeper"; wait cmd "a" publishing "NEVER"; start cmd "a" wait publishing "NEVER"; }
script "in vain" { start cmd "a" wait publishing "NEVER" timeout ms 300 then abort; }
script "ready" { start cmd "a" wait publishing "LIDAR" timeout ms 8000 then abort; start cmd "b"; }
)";

class SheriffTest : public ProcmanBench {
 protected:
  SheriffTest() { config_ = write_file("robot.procman", kRobot); }

  std::unique_ptr<Program> start_sheriff(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"marco-procman-sheriff", config_});
    return start_program(arguments);
  }

  std::string config_;
};

// The public sheriff hangs here for ever, deaf to SIGTERM.
TEST_F(SheriffTest, ScriptsRunScripts) {
  start_deputy({"--script", config_});
  auto sheriff = start_sheriff({"go", "-n", "--output"});
  EXPECT_EQ(sheriff->wait_s(10.0), 0) << programs_output();
  EXPECT_TRUE(wait_until([&] { return runs("a", 1) && runs("c", 2) && has_ended("b", 1); }));
  EXPECT_THAT(programs_output(), HasSubstr("a| from a"));
  EXPECT_THAT(programs_output(), HasSubstr("script go is done"));
}

TEST_F(SheriffTest, SigtermAlwaysEndsIt) {
  start_deputy({"--script", config_});
  auto sheriff = start_sheriff({"-n", "--script", "for ever"});
  ASSERT_TRUE(wait_until([&] { return runs("c", 2); }));
  sheriff->signal(SIGTERM);
  EXPECT_EQ(sheriff->wait_s(20.0), 1) << "1: the script was not done";
  auto alone = start_sheriff({"-n", "--script", "go"});  // and while it waits for a deputy
  deputy_->signal(SIGSTOP);
  wait_until([] { return false; }, 0.5);
  alone->signal(SIGTERM);
  EXPECT_EQ(alone->wait_s(20.0), 1);
  deputy_->signal(SIGCONT);
}

TEST_F(SheriffTest, AWaitMayHaveAnEnd) {
  start_deputy({"--script", config_});
  auto sheriff = start_sheriff({"-n", "in vain"});
  EXPECT_EQ(sheriff->wait_s(40.0), 1);
  EXPECT_THAT(programs_output(),
              HasSubstr("timed out after 300 ms waiting for cmd \"a\" to publish NEVER"));
}

TEST_F(SheriffTest, PublishingMeansAMessageWasHeard) {
  start_deputy({"--script", config_});
  auto sheriff = start_sheriff({"-n", "ready"});
  ASSERT_TRUE(wait_until([&] { return runs("a", 1); }));
  EXPECT_EQ(sheriff->wait_s(0.3), -1) << "it runs, but does not work yet";
  EXPECT_FALSE(runs("b", 1));
  bus_->publish_raw("LIDAR", std::vector<uint8_t>(8), {});
  EXPECT_EQ(sheriff->wait_s(40.0), 0);
  EXPECT_TRUE(wait_until([&] { return runs("b", 1); }));
}

TEST_F(SheriffTest, TheLastOrderArrivesBeforeItLeaves) {
  config_ = write_file("short.procman",
                       "cmd \"a\" { exec = \"sleep 1000\"; deputy = \"bench\"; }\n"
                       "script \"s\" { start everything; }\n");
  auto sheriff = start_sheriff({"-n", "s"});  // no deputy yet
  wait_until([] { return false; }, 0.3);
  start_deputy({"--script", config_});
  EXPECT_EQ(sheriff->wait_s(40.0), 0);
  EXPECT_TRUE(wait_until([&] { return runs("a", 1); }));
}

TEST_F(SheriffTest, TheLoneSheriffTakesItsCommandsWithIt) {
  config_ =
      write_file("lone.procman",
                 "cmd \"a\" { exec = \"bash -c 'echo $$; sleep 1000'\"; deputy = \"localhost\"; }\n"
                 "script \"s\" { start everything wait \"running\"; wait ms 300; }\n");
  auto sheriff = start_sheriff({"-n", "-l", "s", "--on-script-complete", "exit"});
  pid_t pid = 0;
  ASSERT_TRUE(wait_until([&] { return (pid = status("a").pid) != 0; }));
  EXPECT_TRUE(is_alive(pid));
  EXPECT_EQ(sheriff->wait_s(40.0), 0);
  EXPECT_FALSE(is_alive(pid));
  auto killed = start_sheriff({"-n", "-l", "s"});
  ASSERT_TRUE(wait_until([&] { return status("a").pid != 0 && status("a").pid != pid; }));
  pid = status("a").pid;
  killed->signal(SIGKILL);
  EXPECT_TRUE(wait_until([&] { return !is_alive(pid); })) << "its deputy ends with it";
}

const char* const kLoneRobot = R"(
cmd "base" { exec = "bash -c 'echo drives; exec sleep 1000'"; deputy = "localhost"; }
cmd "short" { exec = "true"; deputy = "localhost"; }
script "drive" { start everything wait "running"; }
)";

// It would take the robot down as soon as the script is done.
TEST_F(SheriffTest, TheLoneSheriffStaysWithWhatItsScriptHasStarted) {
  config_ = write_file("lone.procman", kLoneRobot);
  auto sheriff = start_sheriff({"-n", "-l", "drive"});
  ASSERT_TRUE(wait_until([&] {
    return status("base").pid > 0 &&
           programs_output().find("these keep running: base") != std::string::npos;
  }));
  const pid_t pid = status("base").pid;
  EXPECT_EQ(sheriff->wait_s(0.5), -1);
  EXPECT_TRUE(is_alive(pid));
  sheriff->signal(SIGTERM);
  EXPECT_EQ(sheriff->wait_s(40.0), 0);
  EXPECT_FALSE(is_alive(pid));
  EXPECT_THAT(programs_output(), HasSubstr("marco-procman-sheriff: stopping: base"));
}

TEST_F(SheriffTest, ASheriffThatLeavesSaysWhatRunsOn) {
  start_deputy({"--script", config_});
  auto sheriff = start_sheriff({"-n", "go"});
  EXPECT_EQ(sheriff->wait_s(40.0), 0);
  EXPECT_THAT(programs_output(), HasSubstr("left running under their deputies: a, c"));
}

// The commands run on without their deputy; nothing must be started twice, and the end stops them.
TEST_F(SheriffTest, ADeadLoneDeputyIsStartedAgainAndFindsItsCommands) {
  config_ = write_file("lone.procman", kLoneRobot);
  auto sheriff = start_sheriff({"-n", "-l", "drive"});
  ASSERT_TRUE(wait_until([&] {
    return status("base").pid > 0 &&
           programs_output().find("these keep running: base") != std::string::npos;
  }));
  const pid_t pid = status("base").pid;
  const auto deputy = [&] {
    std::ifstream children("/proc/" + std::to_string(sheriff->pid()) + "/task/" +
                           std::to_string(sheriff->pid()) + "/children");
    pid_t child = 0;
    children >> child;
    return child;
  };
  const pid_t first = deputy();
  ASSERT_GT(first, 0);
  ASSERT_EQ(kill(first, SIGKILL), 0);
  ASSERT_TRUE(wait_until([&] { return deputy() != first && deputy() > 0; }));
  infos_ = 0;
  ASSERT_TRUE(wait_until([&] { return infos_ > 1; })) << "the new one is heard";
  EXPECT_EQ(status("base").pid, pid);
  EXPECT_EQ(status("base").actual_runid, 1);
  EXPECT_TRUE(is_alive(pid));
  EXPECT_THAT(programs_output(), HasSubstr("deputy localhost has ended: killed by signal 9"));
  EXPECT_THAT(programs_output(), HasSubstr("it restarts"));
  const std::string written = file_of_deputy("localhost", "base");
  EXPECT_EQ(written, "drives\n") << "started once";
  const pid_t second = deputy();
  ASSERT_GT(second, 0);
  kill(second, SIGKILL);
  sheriff->signal(SIGTERM);  // at the worst moment
  EXPECT_EQ(sheriff->wait_s(60.0), 0);
  EXPECT_FALSE(is_alive(pid)) << "nothing keeps a robot moving in silence";
}

TEST_F(SheriffTest, ASecondLoneSheriffTouchesNothing) {
  EXPECT_EQ(start_program({"marco-procman-sheriff", "--check-free"})->wait_s(40.0), 0);
  config_ = write_file("lone.procman", kLoneRobot);
  auto sheriff = start_sheriff({"-n", "-l", "drive"});
  ASSERT_TRUE(wait_until([&] {
    return status("base").pid > 0 && has_ended("short", 1) &&
           programs_output().find("these keep running: base") != std::string::npos;
  }));
  const pid_t pid = status("base").pid;
  config_ = write_file("other.procman",
                       "cmd \"base\" { exec = \"sleep 999\"; deputy = \"localhost\"; }\n"
                       "script \"go\" { restart everything; }\n");
  EXPECT_EQ(start_sheriff({"-n", "-l", "go"})->wait_s(40.0), 1);
  EXPECT_EQ(start_program({"marco-procman-sheriff", "--check-free"})->wait_s(40.0), 1);
  EXPECT_THAT(programs_output(),
              HasSubstr("a deputy 'localhost' is already active here and runs base: another"));
  EXPECT_TRUE(is_alive(pid));
  EXPECT_EQ(sheriff->wait_s(0.1), -1);
  sheriff->signal(SIGTERM);
  EXPECT_EQ(sheriff->wait_s(40.0), 0);
}

TEST_F(SheriffTest, AScriptThatNamesSomethingMissingIsTheOnlyOneRefused) {
  config_ = write_file("old.pmd",
                       "group \"one\" { cmd \"a\" { exec = \"sleep 1000\"; host = \"bench\"; } }\n"
                       "group \"two\" { cmd \"a\" { exec = \"sleep 1001\"; host = \"bench\"; } }\n"
                       "script \"good\" { start cmd \"a\" wait \"running\"; }\n"
                       "script \"bad\" { start cmd \"gone\"; }\n");
  start_deputy({"--script", config_});
  EXPECT_EQ(start_sheriff({"-n", "bad"})->wait_s(40.0), 1);
  EXPECT_THAT(programs_output(), HasSubstr("script \"bad\" cannot be run:"));
  EXPECT_THAT(programs_output(), HasSubstr("old.pmd:4:16: expected a command of this file"));
  EXPECT_EQ(start_sheriff({"-n", "good"})->wait_s(40.0), 0);
  EXPECT_TRUE(wait_until([&] { return runs("a", 1) && runs("a (2)", 1); }));
  EXPECT_THAT(programs_output(), HasSubstr("warning: script \"bad\" cannot be run: "));
  EXPECT_THAT(programs_output(), HasSubstr("this one is called \"a (2)\""));
}

TEST_F(SheriffTest, NothingWaitsInSilence) {
  config_ = write_file("silent.procman",
                       "cmd \"base\" { exec = \"bash -c 'echo no device: /dev/ttyUSB1; exec sleep "
                       "1000'\"; deputy = \"bench\"; }\n"
                       "script \"s\" { start cmd \"base\" wait publishing \"ODOMETRY\" timeout ms "
                       "7000 then abort; }\n");
  auto sheriff = start_sheriff({"-n", "s"});
  EXPECT_TRUE(wait_until([&] {
    return programs_output().find("deputy bench was silent for 3 s") != std::string::npos;
  }));
  sheriff->signal(SIGTERM);
  sheriff->wait_s(40.0);
  start_deputy({"--script", config_});
  EXPECT_EQ(start_sheriff({"-n", "s"})->wait_s(60.0), 1);
  EXPECT_THAT(programs_output(),
              testing::ContainsRegex("waits for cmd \"base\" to publish ODOMETRY, for 5 s now\n"
                                     "[0-9:]+   base. no device: /dev/ttyUSB1\n"));
  EXPECT_THAT(programs_output(),
              testing::ContainsRegex("timed out after 7000 ms waiting for .* is aborted\n"
                                     "[0-9:]+   base. no device: /dev/ttyUSB1\n"));
}

TEST_F(SheriffTest, AFloodOfOutputDoesNotFillItsMemory) {
  config_ = write_file("long.procman",
                       "cmd \"a\" { exec = \"sleep 1000\"; deputy = \"bench\"; }\n"
                       "script \"s\" { start cmd \"a\" wait \"running\"; wait ms 600000; }\n");
  start_deputy({"--script", config_});
  auto sheriff = start_sheriff({"-n", "s"});
  ASSERT_TRUE(wait_until([&] { return runs("a", 1); }));
  procman_lcm::output_t output;
  output.utime = 1;
  output.deputy_id = "bench";
  output.num_commands = 1;
  output.command_ids = {"a"};
  output.text = {std::string(1 << 20, 'x')};
  for (int i = 0; i < 400; ++i) {
    output.command_ids[0] = i % 2 == 0 ? "a" : "made up " + std::to_string(i);
    bus_->publish(channels::kOutput, output);
    usleep(2000);
  }
  wait_until([] { return false; }, 1.0);
  EXPECT_EQ(sheriff->wait_s(0.0), -1);
  std::ifstream statm("/proc/" + std::to_string(sheriff->pid()) + "/statm");
  int64_t pages = 0;
  int64_t resident = 0;
  statm >> pages >> resident;
  const double resident_mb = static_cast<double>(resident * sysconf(_SC_PAGESIZE)) * 1e-6;
  std::printf("sheriff after 400 MB of output: %.0f MB\n", resident_mb);
  EXPECT_LT(resident_mb, 250.0);
}

TEST_F(SheriffTest, AfterTheScriptItMayStayAsObserver) {
  start_deputy({"--script", config_});
  auto sheriff = start_sheriff({"-n", "go", "--on-script-complete", "observer"});
  ASSERT_TRUE(wait_until([&] { return runs("c", 2) && has_ended("b", 1); }));
  EXPECT_EQ(sheriff->wait_s(0.5), -1);
  sheriff->signal(SIGTERM);
  EXPECT_EQ(sheriff->wait_s(20.0), 0);
}

TEST_F(SheriffTest, WrongUseAndWrongFilesAreRefusedWithTheirPlace) {
  EXPECT_EQ(start_sheriff({"-n"})->wait_s(40.0), 2);
  EXPECT_EQ(start_sheriff({"-n", "none"})->wait_s(40.0), 1);
  EXPECT_THAT(programs_output(), HasSubstr("there is no script \"none\"; there are: \"go\""));
  EXPECT_NE(start_sheriff({"-n", "-o", "go"})->wait_s(40.0), 0);
  EXPECT_EQ(start_sheriff({"-o", "go"})->wait_s(40.0), 2);
  EXPECT_THAT(programs_output(), HasSubstr("-o only watches: it runs no script"));
  config_ =
      write_file("wrong.procman", "cmd \"a\" { exec = \"x\"; }\nscript \"s\" { start cmd \"q\"; }");
  EXPECT_EQ(start_sheriff({"-n", "s"})->wait_s(40.0), 1);
  EXPECT_THAT(programs_output(), HasSubstr("wrong.procman:1:1: expected an attribute 'deputy'"));
  EXPECT_THAT(programs_output(), HasSubstr("wrong.procman:2:14: expected a command of this file"));
  config_ = "/dev/zero";
  EXPECT_EQ(start_sheriff({"-n", "s"})->wait_s(20.0), 1);
  EXPECT_THAT(programs_output(), HasSubstr("/dev/zero: it is a device, not a file"));
}

}  // namespace
}  // namespace marco::procman
