#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/tests/process/procman/procman_bench.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco::procman {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

// For a machine under load; what comes is seen at once.
constexpr double kPatienceS = 40.0;

const char* const kScreenRobot = R"(
group "drivers" {
  cmd "lidar" { exec = "bash -c 'for i in 1 2 3; do echo scan $i; done; exec sleep 1000'"; deputy = "localhost"; }
  cmd "broken" { exec = "sh -c 'echo no device; exit 3'"; deputy = "localhost"; }
}
cmd "slam" { exec = "sleep 1000"; deputy = "localhost"; }
script "first" { start cmd "slam" wait "running"; }
script "second" { stop everything wait "stopped"; }
)";

/// The sheriff in a terminal of tmux's.
class ScreenTest : public ProcmanBench {
 protected:
  ~ScreenTest() override {
    if (!has_tmux_) return;
    const int session = std::atoi(tmux("display-message -p '#{pane_pid}' 2>/dev/null").c_str());
    tmux("kill-server 2>/dev/null");
    if (session == 0) return;
    // The sheriff's deputy ends after it. The next test's would refuse to work beside it. The bus
    // rests meanwhile: what its handlers refer to has gone with the test.
    const std::string runs =
        "pgrep -r D,R,S,T -s " + std::to_string(session) + " >/dev/null";  // a zombie has ended
    for (double s = 0.0; s < kPatienceS && std::system(runs.c_str()) == 0; s += 0.1) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }

  /// @returns false, after saying so, where there is no tmux.
  bool open_screen(const std::string& arguments, const std::string& size = "-x 120 -y 30") {
    has_tmux_ = std::system("command -v tmux >/dev/null") == 0;
    if (!has_tmux_) {
      std::puts("SKIPPED: tmux is not installed");
      return false;
    }
    const std::string config = write_file("robot.procman", robot_);
    static int servers = 0;
    server_ = ++servers;  // one that is ending must not be met
    const char* folder = std::getenv("MARCO_BIN");
    // What it prints after the screen, and its exit code, stay in view.
    tmux("-f /dev/null new-session -d " + size + " \"" +
         std::string(folder != nullptr ? folder : ".") + "/marco-procman-sheriff " + config + " " +
         arguments + "; echo exit \\$?; sleep 1000\"");
    return true;
  }

  std::string tmux(const std::string& command) const {
    const std::string line = "tmux -L marco-test-" + std::to_string(getpid()) + "-" +
                             std::to_string(server_) + " " + command;
    FILE* pipe = popen(line.c_str(), "r");
    std::string text;
    char bytes[4096];
    for (std::size_t size = 0; (size = std::fread(bytes, 1, sizeof bytes, pipe)) > 0;) {
      text.append(bytes, size);
    }
    pclose(pipe);
    return text;
  }
  std::string file(const std::string& name) const {
    std::ifstream in(folder_ + "/" + name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void keys(const std::string& names) const { tmux("send-keys " + names); }
  std::string screen() const { return tmux("capture-pane -p"); }
  std::string coloured_screen() const { return tmux("capture-pane -p -e"); }

  ::testing::AssertionResult shows(const std::string& pattern) {
    const testing::Matcher<std::string> matcher = ContainsRegex(pattern);
    if (wait_until([&] { return matcher.Matches(screen()); }, kPatienceS))
      return testing::AssertionSuccess();
    return testing::AssertionFailure() << "'" << pattern << "' is not in:\n" << screen();
  }

  std::string robot_ = kScreenRobot;
  int server_ = 0;
  bool has_tmux_ = false;
};

TEST_F(ScreenTest, ShowsStartsStopsAndRunsScripts) {
  if (!open_screen("-l")) return;
  ASSERT_TRUE(shows("Procman Sheriff .* localhost: load"));
  EXPECT_TRUE(shows("slam +localhost +Stopped \\(OK\\)"));
  EXPECT_TRUE(shows("- drivers +localhost +Stopped \\(OK\\)"));
  keys("Down s");  // the group
  EXPECT_TRUE(shows("lidar +localhost +Running"));
  EXPECT_TRUE(shows("broken +localhost +Stopped \\(Error\\)"));
  EXPECT_TRUE(shows("drivers +localhost +Mixed"));
  EXPECT_TRUE(shows("broken: Stopped \\(Error\\), exit 3"));
  keys("Down Down");
  EXPECT_TRUE(shows("output of lidar\nscan 1\nscan 2\nscan 3"));
  // Black on green, white on red.
  EXPECT_THAT(coloured_screen(), ContainsRegex("\x1b\\[30m\x1b\\[42m Running"));
  EXPECT_THAT(coloured_screen(), ContainsRegex("\x1b\\[37m\x1b\\[41m Stopped \\(Error"));
  keys("t");
  EXPECT_TRUE(shows("lidar +localhost +Stopped \\(OK\\)"));
  keys("C-s");
  EXPECT_TRUE(shows("lidar +localhost +Running"));
  keys("Up Up Left");
  EXPECT_TRUE(shows("\\+ drivers"));
  EXPECT_THAT(screen(), Not(HasSubstr("  lidar")));
  keys("Right R");
  EXPECT_TRUE(shows("first *\n.* second"));
  keys("Enter");
  EXPECT_TRUE(shows("slam +localhost +Running"));
  EXPECT_TRUE(shows("script first is done"));
  keys("R Down Enter");
  EXPECT_TRUE(shows("script second is done"));
  EXPECT_TRUE(shows("slam +localhost +Stopped \\(OK\\)"));
  keys("'?'");
  EXPECT_TRUE(shows("observer on or off"));
  keys("Escape o");
  EXPECT_TRUE(shows("Procman Observer"));
  keys("q");
  EXPECT_TRUE(shows("exit 0"));
}

// A session without a controlling terminal gets no SIGHUP.
TEST_F(ScreenTest, EndsWithItsTerminal) {
  Descriptor terminal(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
  ASSERT_TRUE(grantpt(terminal.get()) == 0 && unlockpt(terminal.get()) == 0);
  const char* bin = std::getenv("MARCO_BIN");
  const std::string program = std::string(bin != nullptr ? bin : ".") + "/marco-procman-sheriff";
  const pid_t sheriff = fork();
  if (sheriff == 0) {
    setsid();
    const int line = open(ptsname(terminal.get()), O_RDWR | O_NOCTTY);
    for (const int standard : {0, 1, 2}) dup2(line, standard);
    setenv("TERM", "xterm", 1);
    execl(program.c_str(), program.c_str(), "-o", nullptr);
    _exit(127);
  }
  char shown[4096];
  EXPECT_GT(read(terminal.get(), shown, sizeof shown), 0);
  terminal.reset();
  int status = -1;
  EXPECT_TRUE(
      wait_until([&] { return waitpid(sheriff, &status, WNOHANG) == sheriff; }, kPatienceS));
  if (status == -1) kill(sheriff, SIGKILL);
  EXPECT_EQ(status, 0);
}

TEST_F(ScreenTest, RestartsKeepTheCommandChosenAndScrollingWorks) {
  if (!open_screen("-l --script first")) return;
  ASSERT_TRUE(shows("slam +localhost +Running"));
  wait_until([&] { return status("slam").pid != 0; });
  const int32_t pid = status("slam").pid;
  keys("r");
  EXPECT_TRUE(wait_until([&] { return status("slam").pid != 0 && status("slam").pid != pid; }));
  EXPECT_TRUE(shows("slam +localhost +Running"));
  keys("Down Down Down C-r");
  EXPECT_TRUE(shows("output of lidar\nscan 1"));
  for (int i = 0; i < 15; ++i) {
    const int32_t before = status("lidar").pid;
    keys("r");
    wait_until([&] { return status("lidar").pid != 0 && status("lidar").pid != before; },
               kPatienceS);
  }
  keys("PPage");
  EXPECT_TRUE(shows("lines up"));
  keys("End");
  EXPECT_TRUE(wait_until([&] { return screen().find("lines up") == std::string::npos; }))
      << screen();
}

TEST_F(ScreenTest, CommandsAreMadeChangedRemovedAndWritten) {
  if (!open_screen("-l --accept-any-orders")) return;
  ASSERT_TRUE(shows("slam +localhost +Stopped \\(OK\\)"));
  keys("n");
  EXPECT_TRUE(shows("working_directory"));
  keys("-l gps");
  keys("Enter");
  keys("-l 'echo fix; exec sleep 1000'");
  keys("C-s");  // echo takes all of it: no shell
  EXPECT_TRUE(shows("gps +localhost +Stopped"));
  keys("s");
  EXPECT_TRUE(shows("output of gps\nfix; exec sleep 1000"));
  keys("C-e");
  EXPECT_TRUE(shows("exec +echo fix; exec sleep 1000_"));
  keys("C-u");
  keys("-l 'sleep 1000'");
  keys("C-s");
  EXPECT_TRUE(shows("gps +localhost +Stopped \\(OK\\) +[0-9.]+ +[0-9]+ +sleep 1000"));
  keys("s");
  EXPECT_TRUE(shows("gps +localhost +Running"));
  keys("w");
  EXPECT_TRUE(shows("write the file .Enter, Esc.: .*robot.procman"));
  keys("-l .saved");
  keys("Enter");
  EXPECT_TRUE(shows("written: .*robot.procman.saved"));
  keys("DC");
  EXPECT_TRUE(shows("Del again removes gps"));
  keys("DC");
  EXPECT_TRUE(wait_until([&] { return screen().find("gps  ") == std::string::npos; }, kPatienceS));
  keys("n Escape");
  EXPECT_TRUE(shows("s start  t stop"));
  keys("q");
  EXPECT_TRUE(shows("exit 0"));
  const std::string written = file("robot.procman.saved");
  EXPECT_THAT(written, HasSubstr("cmd \"gps\" {\n  exec = \"sleep 1000\";\n"));
  EXPECT_THAT(written, HasSubstr("script \"second\""));
}

TEST_F(ScreenTest, SigtermEndsItAndRestoresTheTerminal) {
  if (!open_screen("--script first")) return;  // no deputy: it waits for ever
  ASSERT_TRUE(shows("no deputy yet"));
  EXPECT_TRUE(shows("script first is running, waits for cmd \"slam\" to run"));
  const std::string pid = tmux("list-panes -F '#{pane_pid}'");
  std::system(
      ("kill -TERM $(ps -o pid= --ppid " + pid.substr(0, pid.find('\n')) + " | head -1)").c_str());
  EXPECT_TRUE(shows("exit 0"));
}

TEST_F(ScreenTest, TheFirstScreenSaysWhatToDoAndEightyColumnsAreEnough) {
  robot_ += "script \"gone\" { start cmd \"nothing\"; }\n";
  for (int i = 10; i < 20; ++i) {
    robot_ +=
        "cmd \"x" + std::to_string(i) + "\" { exec = \"seq -s, 1 60\"; deputy = \"localhost\"; }\n";
  }
  if (!open_screen("-l", "-x 80 -y 24")) return;
  ASSERT_TRUE(shows("1 warnings about the file: e shows them"));
  EXPECT_TRUE(shows("R runs a script of the file .first, second, gone."));
  EXPECT_TRUE(shows("x19 +localhost +Stopped \\(OK\\)")) << "room for 13 rows and more";
  EXPECT_TRUE(shows("1 more rows below"));
  keys("R Down Down Enter");
  EXPECT_TRUE(shows("script .gone. cannot be run: e shows the reason"));
  keys("e");
  EXPECT_TRUE(shows("script .gone. cannot be run; /"));
  keys("e");
  keys("Down s");  // x10
  EXPECT_TRUE(shows("output of x10"));
  EXPECT_TRUE(shows("1,2,3,.*,29,30\n,31,32,")) << "long lines are wrapped";
  keys("'?'");
  EXPECT_TRUE(shows("Space    EMERGENCY STOP      r \\^R  restart"));
  EXPECT_TRUE(shows("s, t and r on a group mean all its commands."));
  keys("Escape d");
  EXPECT_TRUE(shows("localhost: load .*GB free, [0-9.]+ s ago"));
  keys("Escape Down Down Down Down Down Down Down Down Down Down Down Down Down");
  EXPECT_TRUE(shows("1 more above"));
}

TEST_F(ScreenTest, SpaceStopsAllBasesAndAnotherKeyReleasesThem) {
  std::vector<bool> heard;
  bus_->subscribe<emergency_stop_t>(
      "EMERGENCY_STOP", drops_,
      [&](const emergency_stop_t& message, const auto&) { heard.push_back(message.engaged != 0); });
  if (!open_screen("-l")) return;
  ASSERT_TRUE(shows("slam +localhost +Stopped"));
  keys("Space");
  EXPECT_TRUE(shows("EMERGENCY STOP, U releases it; by sheriff"));
  EXPECT_TRUE(wait_until([&] { return std::count(heard.begin(), heard.end(), true) > 5; }));
  keys("U");
  EXPECT_TRUE(shows("the emergency stop is released"));
  EXPECT_TRUE(shows("Procman Sheriff"));
  EXPECT_TRUE(wait_until([&] { return !heard.back(); }));
}

TEST_F(ScreenTest, AStopIsObeyedWhileAScriptRuns) {
  robot_ += "script \"long\" { start cmd \"slam\" wait \"running\"; wait ms 600000; }\n";
  if (!open_screen("-l --script long")) return;
  ASSERT_TRUE(shows("slam +localhost +Running"));
  keys("r");
  EXPECT_TRUE(shows("a script is running: a = abort it; t stops the command"));
  keys("o t");  // who only watches stops nothing
  EXPECT_TRUE(shows("slam +localhost +Stopped \\(OK\\)"));
}

TEST_F(ScreenTest, QuitAsksBeforeItStopsWhatRuns) {
  if (!open_screen("-l --script first")) return;
  ASSERT_TRUE(shows("slam +localhost +Running"));
  ASSERT_TRUE(wait_until([&] { return status("slam").pid != 0; }));
  const int32_t pid = status("slam").pid;
  keys("q");
  EXPECT_TRUE(shows("These still run:"));
  EXPECT_TRUE(shows("y  stop them and quit .their deputy ends with this screen."));
  keys("c q n");  // n is no answer here
  EXPECT_TRUE(shows("These still run:"));
  EXPECT_TRUE(is_alive(pid));
  keys("y");
  EXPECT_TRUE(shows("stopping: slam"));
  EXPECT_TRUE(shows("exit 0"));
  EXPECT_FALSE(is_alive(pid));
}

TEST_F(ScreenTest, WithADeputyOfItsOwnQuitMayLeaveOrStopWhatRuns) {
  robot_ = "cmd \"slam\" { exec = \"sleep 1000\"; deputy = \"bench\"; }\n";
  start_deputy();
  if (!open_screen("")) return;
  ASSERT_TRUE(shows("slam +bench +Stopped"));
  keys("s");
  ASSERT_TRUE(shows("slam +bench +Running"));
  ASSERT_TRUE(wait_until([&] { return status("slam").pid != 0; }));
  const int32_t pid = status("slam").pid;
  keys("q n");
  EXPECT_TRUE(shows("left running under their deputies: slam"));
  EXPECT_TRUE(shows("exit 0"));
  EXPECT_TRUE(is_alive(pid));
  tmux("kill-server 2>/dev/null");
  ASSERT_TRUE(open_screen(""));
  ASSERT_TRUE(shows("slam +bench +Running"));
  keys("q y");
  EXPECT_TRUE(shows("exit 0"));
  EXPECT_FALSE(is_alive(pid));
}

TEST_F(ScreenTest, ForeignOrdersMakeItAnObserver) {
  if (!open_screen("-l")) return;
  ASSERT_TRUE(shows("Procman Sheriff"));
  ASSERT_TRUE(shows("slam +localhost +Stopped"));
  publish_orders("somebody else");
  EXPECT_TRUE(shows("another sheriff is active: now only watching"));
  EXPECT_TRUE(shows("Procman Observer"));
}

// A script waited for ever when anybody else gave an order: the sheriff only watched from then on.
class ScriptAmongOthersTest : public ScreenTest {
 protected:
  ScriptAmongOthersTest() {
    robot_ = R"(
      cmd "one" { exec = "sleep 1000"; deputy = "bench"; auto_respawn = "true"; }
      cmd "two" { exec = "sleep 1001"; deputy = "bench"; }
      script "go" {
        restart cmd "one" wait "running";
        wait cmd "one" publishing "GO";
        restart cmd "two" wait "running";
      })";
  }

  /// Runs the script as often as MARCO_PROCMAN_ROUNDS says, with others at work while it waits.
  void run_rounds(const std::function<void()>& disturb) {
    start_deputy({"--script", write_file("robot.procman", robot_)});
    if (!open_screen("")) return;
    ASSERT_TRUE(shows("one +bench +Stopped"));
    const char* rounds = std::getenv("MARCO_PROCMAN_ROUNDS");
    for (int round = 1; round <= (rounds != nullptr ? std::atoi(rounds) : 2); ++round) {
      const int32_t before = status("two").actual_runid;
      keys("R Enter");
      ASSERT_TRUE(shows("script go is running"));
      ASSERT_TRUE(wait_until([&] { return status("one").pid != 0; }));
      disturb();
      const auto goes_on = [&] {
        bus_->publish_raw("GO", {}, {});
        return status("two").actual_runid > before && status("two").pid != 0;
      };
      ASSERT_TRUE(wait_until(goes_on, 20.0)) << "round " << round << screen();
      EXPECT_TRUE(shows("s start  t stop")) << "the script's end";
    }
  }
  void order(const std::string& action) {
    auto guest = start_program({"marco-procman-order", action, "one"});
    while (guest->wait_s(0.0) < 0) wait_until([] { return false; }, 0.05);
    EXPECT_EQ(guest->wait_s(0.0), 0) << programs_output();
  }
};

TEST_F(ScriptAmongOthersTest, ItEndsWhenAGuestGivesAnOrder) {
  run_rounds([&] {
    const int32_t before = status("one").pid;
    order("restart");
    EXPECT_TRUE(wait_until([&] { return status("one").pid != before && status("one").pid != 0; }));
  });
  EXPECT_TRUE(shows("Procman Sheriff"));
  order("stop");
  EXPECT_TRUE(shows("one +bench +Stopped \\(OK\\)")) << "as wanted by a guest";
  keys("s");
  EXPECT_TRUE(shows("one +bench +Running"));
}

TEST_F(ScriptAmongOthersTest, ItEndsWithAnObserverOrAnotherSheriffBesideIt) {
  const std::string sheriff = std::string(std::getenv("MARCO_BIN")) + "/marco-procman-sheriff ";
  const auto open_another = [&](const std::string& arguments) {
    tmux("new-window -d -n other '" + sheriff + folder_ + "/robot.procman " + arguments + "'");
    wait_until([] { return false; }, 2.5);
    tmux("kill-window -t other");
  };
  run_rounds([&] {
    open_another("-o");
    open_another("");
  });
  EXPECT_TRUE(shows("Procman Sheriff")) << "the other one has yielded to the script";
  publish_orders("a sheriff that repeats its orders");
  EXPECT_TRUE(shows("Procman Observer")) << "without a script the newest takes over";
}

TEST_F(ScreenTest, WithoutATerminalItSaysWhatToDo) {
  auto sheriff =
      start_program({"marco-procman-sheriff", write_file("robot.procman", kScreenRobot)});
  EXPECT_EQ(sheriff->wait_s(5.0), 1);
  EXPECT_THAT(programs_output(),
              HasSubstr("this is not a terminal; to run without a screen: -n SCRIPT"));
}

}  // namespace
}  // namespace marco::procman
