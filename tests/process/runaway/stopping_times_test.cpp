// How long the wheels turn after something has died, by base and by what died: the table of
// docs/stopping.md is printed. Real time, some minutes.
#include <fcntl.h>
#include <termios.h>

#include <fstream>
#include <sstream>

#include "drivers/transport/serial_stream.hpp"
#include "tests/process/runaway/driven_robot.hpp"

namespace marco {
namespace {

using testing::DrivenRobot;
using testing::Program;

class StoppingTimes : public ::testing::TestWithParam<DrivenRobot::Kind> {
 protected:
  /// Once with everything alive and the stick held.
  void by_gamepad(const char* what, double limit_s, const std::function<void()>& dies) {
    if (!robot_.base) robot_.start_base();
    robot_.start_gamepad_and_teleop();
    tell(what, limit_s, dies);
  }
  void tell(const char* what, double limit_s, const std::function<void()>& dies) {
    const double took_s = robot_.stopping_s(dies, 20.0);
    std::printf("| %s | %s | %.1f s | %.0f deg |\n", GetParam().name, what, took_s,
                rad_to_deg(robot_.way_rad));
    std::fflush(stdout);
    EXPECT_LE(took_s, limit_s) << what;
    robot_.end_all_but_simulator();
  }
  void by_orders(const char* what, double limit_s, const std::function<void()>& dies) {
    if (!robot_.base) robot_.start_base();
    robot_.publish(BaseCommand::Kind::turn);
    tell(what, limit_s, dies);
  }

  DrivenRobot robot_{GetParam()};
};

// The senders' limits: half a second twice (gamepad, then base), and the braking. The drivers':
// half a second, and what the guardian takes. Of a cut cable: the board's run or the robot's own
// watchdog; a Create's and a Kobuki's end with the cut.
TEST_P(StoppingTimes, AreShort) {
  const bool hcs12 = std::string(GetParam().name) == "hcs12";
  const double sender_s = 8.0, driver_s = 5.0, cable_s = hcs12 ? 6.0 : 15.0;
  for (const auto& [name, number] :
       {std::pair{"gamepad TERM", SIGTERM}, {"gamepad KILL", SIGKILL}, {"gamepad STOP", SIGSTOP}}) {
    by_gamepad(name, sender_s, [&, number = number] { robot_.gamepad->signal(number); });
  }
  for (const auto& [name, number] : {std::pair{"teleop KILL", SIGKILL}, {"teleop STOP", SIGSTOP}}) {
    by_gamepad(name, sender_s, [&, number = number] { robot_.teleop->signal(number); });
  }
  for (const auto& [name, number] : {std::pair{"base driver TERM", SIGTERM},
                                     {"base driver KILL", SIGKILL},
                                     {"base driver STOP", SIGSTOP}}) {
    by_gamepad(name, driver_s, [&, number = number] { robot_.base->signal(number); });
  }
  by_gamepad("cable cut", cable_s, [&] {
    robot_.pull_cable(6.0);
    robot_.gamepad.reset();  // it would be obeyed when the cable is back
    robot_.teleop.reset();
  });
  robot_.wait([] { return false; }, 6.0);
  robot_.start_base();
  for (int i = 0; i < 20; ++i) {
    robot_.publish(BaseCommand::Kind::velocity);
    robot_.wait([] { return false; }, 0.1);
  }
  tell("orders no longer arrive", sender_s, [] {});
}

// A leg of 3 rad is under way: nobody repeats it.
TEST_P(StoppingTimes, OfALegAreItsOwn) {
  const double leg_s = 40.0, driver_s = 5.0;
  std::ofstream(robot_.file("tour.toml")) << "start_m = [2.0, 3.0]\n[[steps]]\nkind = \"face\"\n"
                                             "heading_deg = 170\n";
  robot_.start_base();
  const auto tour = robot_.start("marco-tour", {robot_.file("tour.toml"), "--pose", "true"});
  tell("tour runner KILL", leg_s, [&] { tour->signal(SIGKILL); });
  by_orders("base driver KILL in a leg", driver_s, [&] { robot_.base->signal(SIGKILL); });
  by_orders("base driver STOP in a leg", driver_s, [&] { robot_.base->signal(SIGSTOP); });
  by_orders("cable cut in a leg", leg_s, [&] { robot_.pull_cable(10.0); });
}

/// A cgroup of this test's own, or none where the system makes none.
class Freezer {
 public:
  Freezer() {
    std::ifstream mounts("/proc/self/mounts");
    for (std::string line; std::getline(mounts, line);) {
      std::istringstream fields(line);
      std::string device, folder, kind;
      fields >> device >> folder >> kind;
      if (kind == "cgroup2") path_ = folder + "/marco-test-" + std::to_string(getpid());
    }
    if (path_.empty() || mkdir(path_.c_str(), 0700) != 0) path_.clear();
  }
  ~Freezer() {
    if (!path_.empty()) rmdir(path_.c_str());
  }
  const std::string& path() const { return path_; }
  void set(bool frozen) const { std::ofstream(path_ + "/cgroup.freeze") << (frozen ? 1 : 0); }

 private:
  std::string path_;
};

// Half a second, and what the guardian takes.
TEST_P(StoppingTimes, OfAHungDriverAreShort) {
  const double driver_s = 5.0;
  by_gamepad("driver's process group STOP", driver_s, [&] { kill(-robot_.base->pid(), SIGSTOP); });
  if (const Freezer freezer; !freezer.path().empty()) {
    robot_.start_base(freezer.path());
    by_gamepad("driver's cgroup frozen", driver_s, [&] { freezer.set(true); });
    freezer.set(false);
  } else {
    std::puts("no cgroup can be made here: not frozen");
  }
  // Nobody is left to stop it but the base itself.
  const double forever_s = std::numeric_limits<double>::infinity();
  robot_.start_base();
  const pid_t guardian = robot_.guardian(robot_.base->pid());
  ASSERT_GT(guardian, 0);
  by_gamepad("driver and guardian STOP", forever_s, [&] {
    kill(guardian, SIGSTOP);
    robot_.base->signal(SIGSTOP);
  });
  kill(guardian, SIGKILL);
}

// Nobody reaches the base, and what was said to it meanwhile must not arrive afterwards.
TEST_P(StoppingTimes, OfALineThatTakesNoBytesEndWithThat) {
  const double blocked_s = 3.0;
  const drivers::FileHandle port(open(robot_.file("ports/base").c_str(), O_RDWR | O_NOCTTY));
  by_gamepad("line takes no bytes for 3 s", blocked_s + 5.0, [&] {
    tcflow(port.get(), TCOOFF);
    robot_.wait([] { return false; }, blocked_s);
    robot_.gamepad.reset();  // it would be obeyed
    robot_.teleop.reset();
    tcflow(port.get(), TCOON);
  });
}

INSTANTIATE_TEST_SUITE_P(Bases,
                         StoppingTimes,
                         ::testing::Values(DrivenRobot::kHcs12,
                                           DrivenRobot::kPioneer,
                                           DrivenRobot::kHomeMade,
                                           DrivenRobot::kCreate,
                                           DrivenRobot::kKobuki),
                         [](const auto& base) { return std::string(base.param.name); });

}  // namespace
}  // namespace marco
