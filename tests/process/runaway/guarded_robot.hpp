#pragma once

#include <algorithm>
#include <deque>

#include "lcm_tools/base/format.hpp"
#include "tests/process/runaway/driven_robot.hpp"

namespace marco::testing {

/// A base of ours, its shipped settings, and the front of its body.
struct GuardedBase {
  DrivenRobot::Kind kind;
  double front_m;
  bool has_sonars = false;  ///< which the guard drives by
};
inline constexpr GuardedBase kGuardedBases[] = {
    {DrivenRobot::kHcs12, 0.30},
    {DrivenRobot::kPioneer, 0.23, true},
    {{"create", "config/robots/create.toml", "marco-create", "config/robots/create/create.toml"},
     0.17},
    {{"kobuki", "config/robots/kobuki.toml", "marco-kobuki", "config/robots/kobuki/kobuki.toml"},
     0.18},
    {DrivenRobot::kHomeMade, 0.12},
};

/// What the files of a guarded robot hold: it must outlive the processes that read them.
struct GuardedFiles {
  TemporaryFolder folder;
  std::string world = path("world.toml"), robot = path("robot.toml"), laser = path("laser.toml");

  std::string path(const char* name) const { return (folder.path() / name).string(); }
};

/// A robot with an LD19 that drives straight at a wall 3 m ahead, and what came of it.
class GuardedRobot {
 public:
  static constexpr double kWallM = 5.0;
  /// @param told_height_m  by the laser's SENSOR_INFO. @param height_m  where it is.
  GuardedRobot(const GuardedBase& base, double told_height_m, double height_m)
      : base_(base), robot(kind_of(base, told_height_m, height_m), files_.world) {
    laser = robot.start("marco-ldlidar",
                        {"--config", files_.laser, "--device", robot.file("ports/laser")});
    robot.start_base();
    wait(2.0);
  }

  /// Orders 30 m, and again while that is refused or aborted, until an obstacle shortens it or for
  /// so long: on a busy machine orders are too old and sensors silent now and then.
  /// @param tick  ten times a second.
  void drive(
      double patience_s, const std::function<void()>& tick = [] {}) {
    using Fate = BaseStatus::Command;
    int64_t id = 0;
    for (double t_s = 0.0; t_s < patience_s; t_s += 0.1) {
      const Fate fate = robot.status->command_id == id ? robot.status->command : Fate::running;
      if (id == 0 || fate == Fate::refused || fate == Fate::aborted) {
        id = robot.publish(BaseCommand::Kind::move);
      }
      if (fate == Fate::shortened) break;
      tick();
      wait(0.1);
      take_note();
    }
    wait(1.5);
  }
  void wait(double seconds) {
    robot.wait([] { return false; }, seconds);
  }
  double front_m() const { return robot.truth().world_from_robot.x_m + base_.front_m; }
  double gap_m() const { return kWallM - front_m(); }

 private:
  void take_note() {
    const Utime now = robot.truth().utime;
    if (!ways_.empty() && (now - ways_.front().first).seconds() > 0.5) {
      const double m_per_s =
          (front_m() - ways_.front().second) / (now - ways_.front().first).seconds();
      fastest_m_per_s = std::max(fastest_m_per_s, m_per_s);
      if (gap_m() < 0.02) contact_m_per_s = std::max(contact_m_per_s, m_per_s);
      ways_.pop_front();
    }
    ways_.emplace_back(now, front_m());
    const std::string guard = BaseNote(robot.status->note).guard;
    if (guard.size() > words.size()) words = guard;
  }
  DrivenRobot::Kind kind_of(const GuardedBase& base, double told_height_m, double height_m) {
    std::ofstream(files_.world) << "floor_m = [0, 0, 5, 6]\nceiling_m = 2.5\n[[walls]]\n"
                                   "corners_m = [0, 0, 5, 0, 5, 6, 0, 6, 0, 0]\nheight_m = 2.5\n";
    std::ifstream in(base.kind.robot);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    std::ofstream(files_.robot)
        << text.substr(0, std::min(text.find("\n[pantilt]"), text.find("\n[[lasers]]")))
        << format(
               "\n[[lasers]]\nport = \"laser\"\ndevice = \"ld19\"\nposition_m = [0.0, 0.0, %g]\n",
               height_m);
    std::ofstream(files_.laser) << format("[place]\nposition_m = [0.0, 0.0, %g]\n", told_height_m);
    DrivenRobot::Kind kind = base.kind;
    kind.robot = files_.robot.c_str();
    return kind;
  }

  GuardedFiles files_;
  GuardedBase base_;
  std::deque<std::pair<Utime, double>> ways_;  ///< of the last half second

 public:
  DrivenRobot robot;
  std::unique_ptr<Program> laser;
  double fastest_m_per_s = 0.0, contact_m_per_s = 0.0;
  std::string words;  ///< the guard's longest
};

}  // namespace marco::testing
