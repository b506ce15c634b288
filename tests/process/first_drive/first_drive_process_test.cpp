// marco-first-drive at a terminal, with emulated bases: a person answers, and pushes the robot.
#include <gmock/gmock.h>
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"

namespace marco {
namespace {

using drivers::wall_now;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Program;

// What takes a second may take this long on a machine that stands still now and then.
constexpr double kPatienceS = 60.0;

struct Base {
  const char* robot;
  const char* driver;
  const char* config;
  const char* laser;
  const char* laser_config;
  bool has_bumpers = true;
};
std::vector<Base> tested_bases() {
  std::vector<Base> bases{{"homemade", "marco-textbase", "textbase", "marco-ldlidar", "ldlidar"}};
  if (std::getenv("MARCO_ALL_BASES") == nullptr) return bases;
  bases.push_back({"create", "marco-create", "create", "marco-ldlidar", "ldlidar"});
  bases.push_back({"kobuki", "marco-kobuki", "kobuki", "marco-ldlidar", "ldlidar"});
  bases.push_back({"marco", "marco-p2os", "p2os", "marco-leuze", "leuze"});
  bases.push_back({"michoacan", "marco-base", "base", "marco-sick", "sick", false});
  return bases;
}

class FirstDriveProcess : public ::testing::TestWithParam<Base> {
 protected:
  FirstDriveProcess() : bus_("") {
    bus_.subscribe<pose2_t>(channels::kTruePose, drops_, [this](const auto& message, const auto&) {
      on_truth(from_message(message));
    });
    bus_.subscribe<base_status_t>(
        channels::kBaseStatus, drops_,
        [this](const auto& message, const auto&) { status_ = from_message(message); });
    bus_.subscribe<base_command_t>(
        channels::kBaseCommand, drops_,
        [this](const auto& message, const auto&) { orders_.push_back(from_message(message)); });
    bus_.subscribe_raw(channels::kLidarPattern, [this](const auto&) { ++scans_; });
    // The wall ahead is the nearest.
    std::ofstream(at("room.toml")) << "floor_m = [0, 0, 4.4, 8]\nceiling_m = 2.5\n[[walls]]\n"
                                      "corners_m = [0, 0, 4.4, 0, 4.4, 8, 0, 8, 0, 0]\n";
    const std::string robot = "config/robots/" + std::string(GetParam().robot);
    start("marco-sim", {"--config", robot + ".toml", "--world", at("room.toml"), "--start", "3.2",
                        "4", "0", "--ports", at("ports")});
    EXPECT_TRUE(wait([this] { return truth_.has_value(); }));
    const auto driver = [&](const char* program, const std::string& config, const char* port) {
      start(program, {"--config", robot + "/" + config + ".toml", "--device", at("ports/") + port});
    };
    driver(GetParam().laser, GetParam().laser_config, "laser");
    if (GetParam().robot == std::string("michoacan")) driver("marco-pantilt", "pantilt", "pantilt");
    start(GetParam().driver, {"--config", robot + "/" + GetParam().config + ".toml", "--device",
                              at("ports/base"), "--no-guard"});
    EXPECT_TRUE(
        wait([this] { return status_ && status_->link == BaseStatus::Link::up && scans_ > 5; }));
  }
  ~FirstDriveProcess() override {
    if (HasFailure()) std::cerr << "== the terminal shows\n" << screen_ << "\n";
    end_terminal();
  }

  void start(const std::string& program, std::vector<std::string> arguments) {
    programs_.push_back(
        std::make_unique<Program>(program, std::move(arguments), at(program + ".log")));
  }
  void start_at_terminal() {
    end_terminal();
    screen_.clear();
    seen_ = 0;
    orders_.clear();
    const std::string program = std::string(std::getenv("MARCO_BIN")) + "/marco-first-drive";
    const std::string report = at("report.toml");
    pid_ = forkpty(&terminal_, nullptr, nullptr, nullptr);
    if (pid_ == 0) {
      execl(program.c_str(), program.c_str(), "--out", report.c_str(), "--robot", "a \"test\"",
            nullptr);
      _exit(127);
    }
  }
  void end_terminal() {
    hang_up();
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  void hang_up() {
    if (terminal_ >= 0) close(terminal_);
    terminal_ = -1;
  }
  void press(char key) { EXPECT_EQ(write(terminal_, &key, 1), 1); }
  /// As a terminal repeats it.
  void hold_space(double seconds, double until_repeat_s = 0.3) {
    press(' ');
    wait([] { return false; }, until_repeat_s);
    for (const Utime end = wall_now() + Duration::from_seconds(seconds - until_repeat_s);
         wall_now() < end;) {
      press(' ');
      wait([] { return false; }, 0.04);
    }
  }
  bool sees(const std::string& text) {
    const bool found = wait([&] { return screen_.find(text, seen_) != std::string::npos; });
    if (found) seen_ = screen_.find(text, seen_) + text.size();
    EXPECT_TRUE(found) << "\"" << text << "\" is never shown";
    return found;
  }
  void answer(const std::string& question, char key) {
    if (sees(question)) press(key);
  }
  int ends() {
    int status = 0;
    const bool ended = wait([&] {
      if (pid_ > 0 && waitpid(pid_, &status, WNOHANG) == pid_) pid_ = -1;
      return pid_ == -1;
    });
    if (!ended) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  bool wait(const std::function<bool()>& done, double seconds = kPatienceS) {
    const Utime end = wall_now() + Duration::from_seconds(seconds);
    while (wall_now() < end && !done()) {
      bus_.handle_once(5);
      read_screen();
    }
    return done();
  }
  void read_screen() {
    if (terminal_ < 0) return;
    pollfd input{terminal_, POLLIN, 0};
    char text[4096];
    if (poll(&input, 1, 0) <= 0) return;
    if (const ssize_t count = read(terminal_, text, sizeof text); count > 0) {
      screen_.append(text, static_cast<std::size_t>(count));
    }
  }
  void on_truth(const TruePose& pose) {
    if (truth_) {
      const Pose2 step = between(truth_->world_from_robot, pose.world_from_robot);
      if (std::hypot(step.x_m, step.y_m) > 2e-4 || std::abs(step.theta_rad) > 2e-4) {
        moved_ = pose.utime;
        turned_rad_ += std::abs(step.theta_rad);
      }
    }
    truth_ = pose;
  }
  bool moves() const { return (truth_->utime - moved_).seconds() < 0.2; }
  bool rests() const { return (truth_->utime - moved_).seconds() > 1.5; }

  void order(BaseCommand command) {
    command.utime = wall_now();
    command.id = command.utime.us;
    bus_.publish(channels::kBaseCommand, to_message(command));
    pushed_ = command.id;
  }
  /// The hand that moves the robot: its wheels count as if it was pushed.
  void push(BaseCommand::Kind kind, double amount) {
    const Pose2 from = truth_->world_from_robot;
    const auto give = [&] {
      const Pose2 way = between(from, truth_->world_from_robot);
      BaseCommand leg;
      leg.kind = kind;
      leg.distance_m = amount - way.x_m;
      leg.angle_rad = amount - way.theta_rad;
      order(leg);
    };
    give();
    EXPECT_TRUE(wait([&] {
      const bool is_taken = status_->command_id == pushed_;
      if (is_taken && status_->command == BaseStatus::Command::done) return true;
      // Lost, too old or broken off, on a machine that stood.
      const bool lost = !is_taken && (wall_now() - Utime::from_us(pushed_)).seconds() > 3.0;
      if (lost || (is_taken && status_->command != BaseStatus::Command::running)) give();
      return false;
    })) << status_->note;
    EXPECT_TRUE(wait([this] { return rests(); }));
  }
  void push_until_bumped() {
    BaseCommand ahead;
    ahead.kind = BaseCommand::Kind::velocity;
    ahead.velocity_m_per_s = 0.2;
    const std::string question = "Is that the right number";
    EXPECT_TRUE(wait([&] {
      order(ahead);
      wait([] { return false; }, 0.1);
      return screen_.find(question, seen_) != std::string::npos;
    }));
    order({});
    push(BaseCommand::Kind::move, -1.8);  // far enough that noise moves no bearing
  }
  /// Those of the kind that drives: from the first to the last [s].
  double driven_s() const {
    std::optional<Utime> first, last;
    for (const BaseCommand& one : orders_) {
      if (one.kind != BaseCommand::Kind::velocity) continue;
      if (!first) first = one.utime;
      last = one.utime;
    }
    return first ? (*last - *first).seconds() : -1.0;
  }

  std::string at(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string report() const { return files::read_whole_file(at("report.toml")); }

  testing::TemporaryFolder folder_;
  process::LcmBus bus_;
  process::DropCounter drops_;
  std::vector<std::unique_ptr<Program>> programs_;
  std::optional<BaseStatus> status_;
  std::optional<TruePose> truth_;
  Utime moved_;
  double turned_rad_ = 0.0;
  std::vector<BaseCommand> orders_;
  int64_t pushed_ = 0;
  int scans_ = 0;
  int terminal_ = -1;
  pid_t pid_ = -1;
  std::string screen_;
  std::size_t seen_ = 0;
};
INSTANTIATE_TEST_SUITE_P(Bases,
                         FirstDriveProcess,
                         ::testing::ValuesIn(tested_bases()),
                         [](const auto& base) { return std::string(base.param.robot); });

TEST_P(FirstDriveProcess, GoesThroughAllStepsAndReports) {
  start_at_terminal();
  answer("off the floor? [y/n/s]", 'y');
  for (int motion = 0; motion < 4; ++motion) {
    ASSERT_TRUE(sees("Hold the space bar"));
    EXPECT_EQ(driven_s(), -1.0) << "it moved before a key was pressed";
    hold_space(2.0);
    EXPECT_GT(driven_s(), 0.1);
    EXPECT_LE(driven_s(), 0.9) << "longer than it may, however long the key is held";
    orders_.clear();
    answer("? [y/n/s]", 'y');
  }
  ASSERT_TRUE(sees("Hold the space bar"));
  hold_space(2.0);
  answer("? [y/n/s]", 'y');
  EXPECT_THAT(status_->note, HasSubstr(kEmergencyStopNote));
  answer("y releases it", 'y');
  EXPECT_TRUE(wait([this] { return status_->note.find(kEmergencyStopNote) != 0; }));
  if (GetParam().has_bumpers) {
    sees("Waiting");
    push_until_bumped();
    answer("Is that the right number", 'y');
  }
  answer("Is that right to 2 cm? [y/n/s]", 'y');
  ASSERT_TRUE(sees("your hand [y/n/s]"));
  answer("deg left", 'y');
  ASSERT_TRUE(sees("your hand [y/n/s]"));
  push(BaseCommand::Kind::turn, deg_to_rad(-45.0));
  answer("deg left", 'y');
  answer("first mark [y/s]", 'y');
  ASSERT_TRUE(sees("second mark"));
  push(BaseCommand::Kind::move, 1.0);
  press('y');
  answer("1 m, to 2 cm? [y/n/s]", 'y');
  EXPECT_EQ(ends(), 0);
  EXPECT_THAT(report(), HasSubstr("base = \"" + status_->base + "\""));
  EXPECT_THAT(report(), HasSubstr("robot = \"a \\\"test\\\"\""));
  EXPECT_THAT(report(), HasSubstr("order_to_motion_s = 0."));
  EXPECT_THAT(report(), HasSubstr("ended_early = \"\""));
  EXPECT_THAT(report(), Not(HasSubstr("WRONG")));
  int steps = 0;
  for (std::size_t i = 0; (i = report().find("result = \"ok\"", i + 1)) != std::string::npos;)
    ++steps;
  EXPECT_EQ(steps, GetParam().has_bumpers ? 11 : 10) << report();
}

TEST_P(FirstDriveProcess, StopsTheRobotHoweverItEnds) {
  const auto turn = [this] {
    start_at_terminal();
    answer("off the floor? [y/n/s]", 'y');
    for (int step = 0; step < 2; ++step) answer("Hold the space bar", 's');
    ASSERT_TRUE(sees("Hold the space bar"));
    turned_rad_ = 0.0;
    press(' ');
    EXPECT_TRUE(wait([this] { return moves(); }));
  };
  const auto expect_rest = [this](bool stop_is_sent) {
    EXPECT_TRUE(wait([this] { return rests(); }, 10.0)) << "it still turns";
    EXPECT_EQ(orders_.back().kind == BaseCommand::Kind::stop, stop_is_sent);
    EXPECT_LE(driven_s(), 0.6);
    EXPECT_LT(turned_rad_, 1.5) << "five times what an idle machine shows";
  };
  turn();  // and nothing more: as a key that is released
  expect_rest(true);
  turn();
  press('x');  // any other key
  expect_rest(true);
  for (const int number : {SIGINT, SIGTERM}) {
    turn();
    if (number == SIGINT) press('\x03');
    if (number == SIGTERM) kill(pid_, SIGTERM);
    EXPECT_EQ(ends(), 128 + number);
    expect_rest(true);
    EXPECT_THAT(report(), HasSubstr("ended_early = \"stopped by a signal\""));
  }
  turn();
  hang_up();
  EXPECT_NE(ends(), -1);
  expect_rest(true);
  EXPECT_THAT(report(), HasSubstr("ended_early = \"stopped by a signal\""));
  turn();
  kill(pid_, SIGKILL);
  EXPECT_EQ(ends(), 128 + SIGKILL);
  expect_rest(false);
  EXPECT_THAT(report(), HasSubstr("name = \"back\""));  // the steps until then are kept
  // The terminal of the base's driver hangs up while the wheels turn. No base may need a watchdog.
  turn();
  programs_.back()->signal(SIGHUP);
  EXPECT_EQ(programs_.back()->wait(kPatienceS), 0) << "it did not leave the motors off";
  EXPECT_EQ(ends(), 1);
  EXPECT_TRUE(wait([this] { return rests(); }, 10.0)) << "it still turns";
  EXPECT_THAT(report(), HasSubstr("the base no longer answers"));
}

}  // namespace
}  // namespace marco
