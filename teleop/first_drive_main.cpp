#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/version.hpp"
#include "teleop/attended_robot.hpp"
#include "teleop/first_drive.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using drivers::wall_now;
using teleop::Check;

constexpr double kVelocity = 0.1;  // m/s
constexpr double kYawRate = 0.4;   // rad/s
constexpr double kRestS = 1.5;     ///< for the robot to stand, and for its base's answers

/// The steps, one after the other, and their report.
class FirstDrive {
 public:
  FirstDrive(process::LcmBus& bus, std::string path, std::string name)
      : robot_(bus), path_(std::move(path)) {
    report_ = {process::version(), std::move(name), "", {}, ""};
  }

  int run() {
    wait_for_base();
    try {
      steps();
    } catch (const std::exception& failure) {
      robot_.send({});  // a stop
      report_.ended_early = failure.what();
      write();
    }
    print(stdout, "\n%s\nThe report is %s\n", report_.to_text().c_str(), path_.c_str());
    if (robot_.is_latched()) std::puts("The emergency stop is engaged: marco stop --release");
    if (process::stop_requested()) return process::kExitSignal + process::stopped_by();
    return report_.is_good() ? process::kExitDone : process::kExitFailed;
  }

 private:
  void wait_for_base() {
    const auto& base = robot_.base;
    const auto is_up = [&] { return base && base->link == BaseStatus::Link::up; };
    const bool ready = robot_.wait(5.0, [&] { return is_up() && !robot_.track.empty(); });
    require(ready, !base     ? "no base answers: start the robot in another terminal (marco run)"
                   : is_up() ? "the base sends no ODOMETRY"
                             : "the base does not answer its driver: " + base->note);
    report_.base = base->base;
    write();  // so that a path that cannot be written is no surprise in the end
  }

  void steps() {
    print(stdout,
          "First drive of %s. y: yes, n: no, s: skip; Ctrl-C stops the robot and ends.\n"
          "It moves only while you hold the space bar, slowly, and never longer than %.1f s.\n",
          report_.base.c_str(), teleop::HeldMotion::kMostS);
    explain("blocks", "Put the robot on blocks, and keep its emergency stop button within reach.");
    may_move_ = judge(Check("blocks"), "Are all wheels off the floor?");
    drive("ahead", 1.0, 0.0, "Did every wheel turn forward?");
    drive("back", -1.0, 0.0, "Did every wheel turn backward?");
    drive("left", 0.0, 1.0, "Did the right wheels turn forward, and the left ones backward?");
    drive("right", 0.0, -1.0, "Did the left wheels turn forward, and the right ones backward?");
    emergency_stop();
    bumper();
    lasers();
    distance();
  }

  void write() { files::write_whole_file(path_, report_.to_toml()); }
  static void explain(const std::string& name, const std::string& text) {
    print(stdout, "\n== %s\n%s\n", name.c_str(), text.c_str());
  }
  /// Takes a step into the report, with the person's answer. @returns whether that is yes
  bool end(Check check, char pressed) {
    check.answer = pressed == 'y' ? "yes" : pressed == 'n' ? "no" : "skipped";
    report_.checks.push_back(std::move(check));
    write();
    return pressed == 'y';
  }
  static void show(const Check& check) {
    for (const auto& [name, value] : check.figures) print(stdout, "%s %.3f\n", name.c_str(), value);
    if (!check.fault.empty()) print(stdout, "WRONG: %s\n", check.fault.c_str());
  }
  bool judge(const Check& check, const std::string& question) {
    show(check);
    return end(check, robot_.ask(question + " [y/n/s]", "yns"));
  }

  enum class EndedBy { release, emergency_stop };
  /// Drives while the space bar is held. @returns what was seen, once the robot rests
  teleop::SeenMotion move(double ahead, double left, EndedBy by) {
    constexpr double kEmergencyAfterRad = 0.06;
    robot_.begin_track();
    robot_.refused.clear();
    BaseCommand order;
    order.kind = BaseCommand::Kind::velocity;
    order.velocity_m_per_s = kVelocity * ahead;
    order.yaw_rate_rad_per_s = kYawRate * left;
    const Utime begin = wall_now();
    std::optional<Utime> stopped;
    for (teleop::HeldMotion held(begin); held.goes(wall_now());) {
      const Pose2 way = teleop::seen_motion(robot_.track, begin, wall_now()).start_from_end;
      if (by == EndedBy::emergency_stop && std::abs(way.theta_rad) > kEmergencyAfterRad) {
        if (!stopped) stopped = wall_now();
        robot_.emergency_stop(process::EmergencyStop::engage);
      }
      robot_.send(order);  // after the stop, too: it must be refused
      robot_.listen(0.05);
      while (const auto pressed = robot_.key()) held.on_key(*pressed, wall_now());
    }
    if (!stopped) stopped = wall_now();
    if (by == EndedBy::emergency_stop) robot_.emergency_stop(process::EmergencyStop::engage);
    robot_.send({});
    robot_.listen(kRestS);
    return teleop::seen_motion(robot_.track, begin, *stopped);
  }
  /// @returns the step after a motion; nothing, and a report of it, when it was skipped
  std::optional<Check> moved(const char* name, double ahead, double left, EndedBy by) {
    explain(name, may_move_ ? "Watch the wheels." : "Skipped: the wheels are not off the floor.");
    Check check(name);
    if (!may_move_ || robot_.ask("Hold the space bar [s: skip]", " s") == 's') {
      end(check, 's');
      return std::nullopt;
    }
    const teleop::SeenMotion seen = move(ahead, left, by);
    check.judge_motion(seen, ahead, left);
    if (!check.fault.empty() && !robot_.refused.empty()) check.fault += ": " + robot_.refused;
    return check;
  }
  void drive(const char* name, double ahead, double left, const char* question) {
    if (const auto check = moved(name, ahead, left, EndedBy::release)) judge(*check, question);
  }
  void emergency_stop() {
    auto check = moved("emergency stop", 0.0, 1.0, EndedBy::emergency_stop);
    if (!check) return;
    if (!robot_.refused.starts_with(kEmergencyStopNote)) {
      check->fault = "no order after the stop was refused; did you hold the key?";
    }
    if (!robot_.is_latched()) check->fault = "the base does not report the stop: switch it off";
    judge(*check, "Did EMERGENCY_STOP stop the wheels while you held the key?");
    if (robot_.ask("y releases it, n leaves it engaged [y/n]", "yn") == 'n') return;
    robot_.emergency_stop(process::EmergencyStop::release);
    robot_.wait(kRestS, [this] { return !robot_.is_latched(); });
  }

  void bumper() {
    const auto& bumpers = robot_.base->bumpers;
    explain("bumper", bumpers.empty() ? "Skipped: this base reports none."
                                      : "Press a bumper with your hand, and keep it pressed.");
    Check check("bumper");
    std::ptrdiff_t number = 0;
    const char pressed =
        bumpers.empty() ? 's' : robot_.ask("Waiting [n: nothing happens, s: skip]", "ns", [&] {
          number = std::find(bumpers.begin(), bumpers.end(), true) - bumpers.begin();
          return number < std::ssize(bumpers);
        });
    if (pressed != '\0') return void(end(check, pressed));
    check.figures = {{"bumper", static_cast<double>(number + 1)}};
    judge(check, "\nIs that the right number, by the driver's configuration?");
  }
  void lasers() {
    if (robot_.scans.empty()) return explain("laser", "Skipped: no laser reports its mount.");
    for (const auto& [channel, laser] : robot_.scans) {
      const Eigen::Vector3d at = laser.robot_from_sensor.translation();
      explain(channel, "Measure its position: above the floor, ahead and left of the wheels.");
      Check check("place of " + channel);
      check.figures = {{"up_m", at.z()}, {"ahead_m", at.x()}, {"left_m", at.y()}};
      judge(check, "Is that right to 2 cm?");
    }
    hand("laser ahead", 0.0, "straight ahead of the robot");
    hand("laser left", 45.0, "to its front left, at 45 degrees");
  }
  void hand(const char* name, double bearing_deg, const char* where) {
    explain(name, std::string("Clear a metre around, and hold your hand 0.3 m ") + where);
    std::optional<teleop::NearestReturn> nearest;
    const char pressed = robot_.ask("y when the nearest return is your hand [y/n/s]\n", "yns", [&] {
      // The person answers to what was shown last.
      if (const auto seen = teleop::nearest_return(robot_.scans, wall_now())) {
        nearest = seen;
        std::printf("\r%5.2f m, %4.0f deg left  ", nearest->range_m,
                    rad_to_deg(nearest->bearing_rad));
      }
      return false;
    });
    Check check(name);
    if (pressed == 'y') check.judge_hand(nearest, bearing_deg);
    show(check);
    end(check, pressed);
  }
  void distance() {
    explain("distance", "Put the robot on the floor, and mark where it stands and 1 m ahead.");
    Check check("distance");
    if (robot_.ask("y when it stands at the first mark [y/s]", "ys") == 's') {
      return void(end(check, 's'));
    }
    robot_.begin_track();
    const char there = robot_.ask(
        "Push it to the second mark; if motors hold it, use marco drive. y when there [y/s]", "ys");
    if (there == 's') return void(end(check, 's'));
    robot_.await_odometry();
    check.judge_push(teleop::seen_motion(robot_.track, {}, {}).start_from_end);
    judge(check, "Was it 1 m, to 2 cm?");
  }

  teleop::AttendedRobot robot_;
  std::string path_;
  teleop::DriveReport report_;
  bool may_move_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-first-drive", [&] {
    process::CommandLine app(
        "Checks a robot that was never driven before, step by step: wheels, emergency stop, "
        "bumper, laser, odometry. It moves only while you hold the space bar, for less than a "
        "second. "
        "docs/first_drive.md explains each step.");
    std::string lcm_url, path = "first_drive.toml", name;
    app.add_option("--out", path, "the report; an existing file is replaced").shows_default();
    app.add_option("--robot", name, "name of the robot, for the report");
    process::add_lcm_url(app, lcm_url);
    if (const auto code = app.parse(argc, argv)) return *code;
    require(isatty(STDIN_FILENO) == 1, "standard input is not a terminal, so keys cannot be read");
    process::catch_stop_signals();
    process::LcmBus bus(lcm_url);
    return FirstDrive(bus, path, name).run();
  });
}
