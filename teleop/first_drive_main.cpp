#include <unistd.h>

#include <cstdio>
#include <utility>

#include "common/input/process/sensor_feed.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/emergency_stop.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcm_tools/process/version.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "teleop/first_drive.hpp"
#include "teleop/terminal.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using drivers::wall_now;
using teleop::Check;

constexpr double kVelocity = 0.1;  // m/s
constexpr double kYawRate = 0.4;   // rad/s
constexpr double kRestS = 1.5;     ///< for the robot to stand, and for its base's answers

/// The robot on the network, and the person at the terminal.
class Robot {
 public:
  explicit Robot(process::LcmBus& bus) : bus_(bus) {
    bus.subscribe<base_status_t>(channels::kBaseStatus, drops_,
                                 [this](const auto& message, const auto&) {
                                   base = from_message(message);
                                   base_heard_ = wall_now();
                                   if (base->command == BaseStatus::Command::refused)
                                     refused = base->note;
                                 });
    bus.subscribe<odometry_t>(
        channels::kOdometry, drops_,
        [this](const auto& message, const auto&) { track.push_back(from_message(message)); });
    feed(bus, drops_, sensors_, {{}, [this] {
                                   while (auto scan = sensors_.next())
                                     scans[scan->info.channel] = std::move(*scan);
                                 }});
  }

  std::optional<BaseStatus> base;
  std::string refused;  ///< why an order was
  std::vector<OdometrySample> track;
  std::map<std::string, SynchronizedScan> scans;  ///< the newest of each laser

  /// The track begins with where the robot is now.
  void begin_track() { track.erase(track.begin(), track.end() - 1); }
  bool is_latched() const { return base->note.starts_with(kEmergencyStopNote); }

  /// Handles messages for so long. @throws std::runtime_error after a signal, and when the base
  /// falls silent.
  void listen(double seconds) {
    constexpr double kSilentS = 2.0;  // a base reports twice a second
    const Utime end = wall_now() + Duration::from_seconds(seconds);
    do {
      const bool all_handled = !bus_.handle_once(10);  // this process may have stood still itself
      if (process::stop_requested()) throw std::runtime_error("stopped by a signal");
      if (all_handled && base && (wall_now() - base_heard_).seconds() > kSilentS) {
        throw std::runtime_error("nothing is heard from the base any more");
      }
    } while (wall_now() < end);
  }
  bool wait(double seconds, const std::function<bool()>& done) {
    const Utime end = wall_now() + Duration::from_seconds(seconds);
    while (!done() && wall_now() < end) listen(0.01);
    return done();
  }

  std::optional<char> key() { return keyboard_.key(); }
  /// One of `keys`, pressed after the question: one that is still held does not count.
  /// @param idle  is called while nothing is pressed; true ends the wait, and 0 is returned
  char ask(
      const std::string& question, const std::string& keys, const std::function<bool()>& idle = [] {
        return false;
      }) {
    for (bool held = true; held;) {
      listen(0.2);
      held = key().has_value();
      while (key()) {
      }
    }
    print(stdout, "%s", question.c_str());
    while (true) {
      std::fflush(stdout);
      listen(0.05);
      const char pressed = key().value_or('\0');
      const bool counts = pressed != '\0' && keys.find(pressed) != std::string::npos;
      if (counts) print(stdout, " %c\n", pressed);
      if (counts || idle()) return counts ? pressed : '\0';
    }
  }

  void send(BaseCommand command) {
    command.utime = wall_now();
    command.id = command.utime.us;
    bus_.publish(channels::kBaseCommand, to_message(command));
  }
  void emergency_stop(process::EmergencyStop what) {
    process::send_emergency_stop(bus_, what, "marco first-drive", "its test");
  }

 private:
  process::LcmBus& bus_;
  process::DropCounter drops_;
  SensorSynchronizer sensors_{{}, lcm_channel_names(), {}};
  teleop::Keyboard keyboard_;
  Utime base_heard_;
};

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
    robot_.wait(
        5.0, [&] { return base && base->link == BaseStatus::Link::up && !robot_.track.empty(); });
    require(base.has_value(),
            "no base answers: start the robot first (marco run ROBOT.procman) in another terminal");
    require(base->link == BaseStatus::Link::up,
            "the base does not answer its driver: " + base->note);
    require(!robot_.track.empty(), "the base sends no ODOMETRY");
    report_.base = base->base;
    write();  // so that a path that cannot be written is no surprise in the end
  }

  void steps() {
    print(stdout,
          "First drive of %s. y: yes, n: no, s: skip; Ctrl-C stops the robot and ends.\n"
          "It moves only while you hold the space bar, slowly, and never longer than %.1f s.\n",
          report_.base.c_str(), teleop::HeldMotion::kMostS);
    explain("blocks", "Put the robot on blocks, and its red button in your reach.");
    may_move_ = judge(Check("blocks"), "Do all wheels hang free?");
    drive("ahead", 1.0, 0.0, "Did each wheel turn as for driving straight ahead?");
    drive("back", -1.0, 0.0, "Did each wheel turn as for driving straight back?");
    drive("left", 0.0, 1.0, "Did the right wheels turn ahead, and the left ones back?");
    drive("right", 0.0, -1.0, "Did the left wheels turn ahead, and the right ones back?");
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
      robot_.send(order);
      robot_.listen(0.05);
      while (const auto pressed = robot_.key()) held.on_key(*pressed, wall_now());
      const Pose2 way = teleop::seen_motion(robot_.track, begin, wall_now()).start_from_end;
      if (by == EndedBy::release || std::abs(way.theta_rad) < kEmergencyAfterRad) continue;
      if (!stopped) stopped = wall_now();
      robot_.emergency_stop(process::EmergencyStop::engage);
    }
    if (!stopped) stopped = wall_now();
    if (by == EndedBy::emergency_stop) robot_.emergency_stop(process::EmergencyStop::engage);
    robot_.send({});
    robot_.listen(kRestS);
    return teleop::seen_motion(robot_.track, begin, *stopped);
  }
  /// @returns the step after a motion; nothing, and a report of it, when it was skipped
  std::optional<Check> moved(const char* name, double ahead, double left, EndedBy by) {
    explain(name, may_move_ ? "Look at the wheels." : "Skipped: the wheels are not free.");
    Check check(name);
    if (!may_move_ || robot_.ask("Hold the space bar [s: skip]", " s") == 's') {
      end(check, 's');
      return std::nullopt;
    }
    const teleop::SeenMotion seen = move(ahead, left, by);
    const Pose2& way = seen.start_from_end;
    check.figures = {{"moved_m", way.x_m},
                     {"turned_deg", rad_to_deg(way.theta_rad)},
                     {"stands_after_s", seen.stands_s}};
    if (seen.begins_s) check.figures.emplace_back("order_to_motion_s", *seen.begins_s);
    const bool as_ordered = left == 0.0 ? ahead * way.x_m > 0.01 && std::abs(way.theta_rad) < 0.2
                                        : left * way.theta_rad > 0.04 && std::abs(way.x_m) < 0.05;
    const std::string why = robot_.refused.empty() ? "" : ": " + robot_.refused;
    if (!as_ordered) check.fault = "odometry shows another motion" + why;
    if (seen.stands_s > 1.0) check.fault = "it did not stop within a second";
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
    if (robot_.wait(kRestS, [this] { return !robot_.is_latched(); })) return;
    Check release("release");
    release.fault = "the base stays stopped: " + robot_.base->note;
    end(release, 'n');
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
    judge(check, "\nIs that the one, as the driver's configuration counts them?");
  }
  void lasers() {
    if (robot_.scans.empty()) return explain("laser", "Skipped: none says where it sits.");
    for (const auto& [channel, laser] : robot_.scans) {
      const Eigen::Vector3d at = laser.robot_from_sensor.translation();
      explain(channel, "Measure where it sits: above the floor, ahead and left of the wheels.");
      Check check("place of " + channel);
      check.figures = {{"up_m", at.z()}, {"ahead_m", at.x()}, {"left_m", at.y()}};
      judge(check, "Is that right to 2 cm?");
    }
    hand("laser ahead", 0.0, "straight ahead of the robot");
    hand("laser left", 45.0, "to its left and ahead, half way between both");
  }
  void hand(const char* name, double bearing_deg, const char* where) {
    explain(name, std::string("Clear a metre around, and hold your hand 0.3 m ") + where);
    std::optional<teleop::NearestReturn> nearest;
    const char pressed = robot_.ask("y when the nearest return is your hand [y/n/s]\n", "yns", [&] {
      nearest = teleop::nearest_return(robot_.scans, wall_now());
      if (nearest) {
        std::printf("\r%5.2f m, %4.0f deg left  ", nearest->range_m,
                    rad_to_deg(nearest->bearing_rad));
      }
      return false;
    });
    Check check(name);
    if (nearest) {
      const double left_deg = rad_to_deg(nearest->bearing_rad);
      check.figures = {{"nearest_m", nearest->range_m}, {"left_deg", left_deg}};
      if (std::abs(left_deg - bearing_deg) > 25.0) check.fault = "the hand is seen elsewhere";
    } else {
      check.fault = "no laser sees anything";
    }
    if (pressed != 'y') check.fault.clear();
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
        "Push it to the second mark; where motors hold it, by marco drive. y when there [y/s]",
        "ys");
    if (there == 's') return void(end(check, 's'));
    const Pose2 way = teleop::seen_motion(robot_.track, {}, {}).start_from_end;
    check.figures = {
        {"moved_m", way.x_m}, {"left_m", way.y_m}, {"turned_deg", rad_to_deg(way.theta_rad)}};
    if (std::abs(way.x_m - 1.0) > 0.1) check.fault = "odometry shows another way than 1 m ahead";
    judge(check, "Was it 1 m, to 2 cm?");
  }

  Robot robot_;
  std::string path_;
  teleop::DriveReport report_;
  bool may_move_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-first-drive", [&] {
    process::CommandLine app(
        "Checks a robot that was never driven before, step by step: wheels, emergency stop, "
        "bumper, laser, odometry. It moves only while the space bar is held, for less than a "
        "second. "
        "docs/first_drive.md explains each step.");
    std::string lcm_url, path = "first_drive.toml", name;
    app.add_option("--out", path, "the report, which is replaced").shows_default();
    app.add_option("--robot", name, "what robot it is, for the report");
    process::add_lcm_url(app, lcm_url);
    if (const auto code = app.parse(argc, argv)) return *code;
    require(isatty(STDIN_FILENO) == 1, "standard input is no terminal, so no key can be read");
    process::catch_stop_signals();
    process::LcmBus bus(lcm_url);
    return FirstDrive(bus, path, name).run();
  });
}
