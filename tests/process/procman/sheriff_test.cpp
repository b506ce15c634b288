#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <thread>

#include "procman/process/descriptor.hpp"
#include "tests/process/procman/procman_bench.hpp"

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
  EXPECT_EQ(sheriff->wait_s(1.0), 1) << "1: the script was not done";
  auto alone = start_sheriff({"-n", "--script", "go"});  // and while it waits for a deputy
  deputy_->signal(SIGSTOP);
  wait_until([] { return false; }, 0.5);
  alone->signal(SIGTERM);
  EXPECT_EQ(alone->wait_s(1.0), 1);
  deputy_->signal(SIGCONT);
}

TEST_F(SheriffTest, AWaitMayHaveAnEnd) {
  start_deputy({"--script", config_});
  auto sheriff = start_sheriff({"-n", "in vain"});
  EXPECT_EQ(sheriff->wait_s(5.0), 1);
  EXPECT_THAT(programs_output(), HasSubstr("waited 300 ms in vain for cmd \"a\" to publish NEVER"));
}

TEST_F(SheriffTest, PublishingMeansAMessageWasHeard) {
  start_deputy({"--script", config_});
  auto sheriff = start_sheriff({"-n", "ready"});
  ASSERT_TRUE(wait_until([&] { return runs("a", 1); }));
  EXPECT_EQ(sheriff->wait_s(0.3), -1) << "it runs, but does not work yet";
  EXPECT_FALSE(runs("b", 1));
  bus_->publish_raw("LIDAR", std::vector<uint8_t>(8), {});
  EXPECT_EQ(sheriff->wait_s(5.0), 0);
  EXPECT_TRUE(wait_until([&] { return runs("b", 1); }));
}

TEST_F(SheriffTest, TheLastOrderArrivesBeforeItLeaves) {
  config_ = write_file("short.procman",
                       "cmd \"a\" { exec = \"sleep 1000\"; deputy = \"bench\"; }\n"
                       "script \"s\" { start everything; }\n");
  auto sheriff = start_sheriff({"-n", "s"});  // no deputy yet
  wait_until([] { return false; }, 0.3);
  start_deputy({"--script", config_});
  EXPECT_EQ(sheriff->wait_s(5.0), 0);
  EXPECT_TRUE(wait_until([&] { return runs("a", 1); }));
}

TEST_F(SheriffTest, TheLoneSheriffTakesItsCommandsWithIt) {
  config_ =
      write_file("lone.procman",
                 "cmd \"a\" { exec = \"bash -c 'echo $$; sleep 1000'\"; deputy = \"localhost\"; }\n"
                 "script \"s\" { start everything wait \"running\"; wait ms 300; }\n");
  auto sheriff = start_sheriff({"-n", "-l", "s"});
  pid_t pid = 0;
  ASSERT_TRUE(wait_until([&] { return (pid = status("a").pid) != 0; }));
  EXPECT_TRUE(is_alive(pid));
  EXPECT_EQ(sheriff->wait_s(5.0), 0);
  EXPECT_FALSE(is_alive(pid));
  auto killed = start_sheriff({"-n", "-l", "s"});
  ASSERT_TRUE(wait_until([&] { return status("a").pid != 0 && status("a").pid != pid; }));
  pid = status("a").pid;
  killed->signal(SIGKILL);
  EXPECT_TRUE(wait_until([&] { return !is_alive(pid); })) << "its deputy ends with it";
}

TEST_F(SheriffTest, AfterTheScriptItMayStayAsObserver) {
  start_deputy({"--script", config_});
  auto sheriff = start_sheriff({"-n", "go", "--on-script-complete", "observer"});
  ASSERT_TRUE(wait_until([&] { return runs("c", 2) && has_ended("b", 1); }));
  EXPECT_EQ(sheriff->wait_s(0.5), -1);
  sheriff->signal(SIGTERM);
  EXPECT_EQ(sheriff->wait_s(1.0), 0);
}

TEST_F(SheriffTest, WrongUseAndWrongFilesAreRefusedWithTheirPlace) {
  EXPECT_EQ(start_sheriff({"-n"})->wait_s(5.0), 1);
  EXPECT_EQ(start_sheriff({"-n", "none"})->wait_s(5.0), 1);
  EXPECT_THAT(programs_output(), HasSubstr("there is no script \"none\"; there are: \"go\""));
  EXPECT_NE(start_sheriff({"-n", "-o", "go"})->wait_s(5.0), 0);
  config_ =
      write_file("wrong.procman", "cmd \"a\" { exec = \"x\"; }\nscript \"s\" { start cmd \"q\"; }");
  EXPECT_EQ(start_sheriff({"-n", "s"})->wait_s(5.0), 1);
  EXPECT_THAT(programs_output(), HasSubstr("wrong.procman:1:1: expected an attribute 'deputy'"));
  EXPECT_THAT(programs_output(), HasSubstr("wrong.procman:2:14: expected a command of this file"));
}

}  // namespace
}  // namespace marco::procman
