#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "drivers/gamepad/codec.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "marco/sim_fault_t.hpp"

namespace marco::testing {

inline pid_t parent_of(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string word; status >> word;) {
    if (word == "PPid:" && status >> pid) return pid;
  }
  return 0;
}

/// A simulated robot and its base driver as processes, with a gamepad and whatever else a test
/// starts; it turns on the spot, so that no wall is met, and tells when it came to rest.
class DrivenRobot {
 public:
  // What takes a second may take this long on a machine that stands still now and then.
  static constexpr double kPatienceS = 60.0;

  struct Kind {
    const char* name;
    const char* robot;
    const char* driver;
    const char* driver_config;
  };
  static constexpr Kind kHcs12{"hcs12", "config/robots/michoacan.toml", "marco-base",
                               "config/robots/michoacan/base.toml"};
  static constexpr Kind kPioneer{"p2os", "config/robots/marco.toml", "marco-p2os",
                                 "config/robots/marco/p2os.toml"};
  static constexpr Kind kHomeMade{"textbase", "config/robots/homemade.toml", "marco-textbase",
                                  "config/robots/homemade/textbase.toml"};
  static constexpr Kind kCreate{"create", "config/robots/create.toml", "marco-create",
                                "config/robots/create/create.toml"};
  static constexpr Kind kKobuki{"kobuki", "config/robots/kobuki.toml", "marco-kobuki",
                                "config/robots/kobuki/kobuki.toml"};

  explicit DrivenRobot(const Kind& kind, const std::string& world = "config/worlds/lab.toml")
      : kind_(kind), bus_("") {
    bus_.subscribe<pose2_t>(channels::kTruePose, drops_, [this](const auto& message, const auto&) {
      on_truth(from_message(message));
    });
    bus_.subscribe<base_status_t>(
        channels::kBaseStatus, drops_,
        [this](const auto& message, const auto&) { status = from_message(message); });
    simulator_ = start("marco-sim", {"--config", kind.robot, "--world", world, "--start", "2", "3",
                                     "0", "--ports", file("ports")});
    EXPECT_TRUE(wait([this] { return truth_.has_value(); })) << log("marco-sim");
    mkfifo(file("pad").c_str(), 0600);
  }

  std::unique_ptr<Program> start(const std::string& program, std::vector<std::string> arguments) {
    return std::make_unique<Program>(program, std::move(arguments), file(program + ".log"));
  }
  /// In a session of its own. @param cgroup  a folder, in which it begins; "" = the test's
  void start_base(const std::string& cgroup = "") {
    base.reset();
    status.reset();
    const std::string join = cgroup.empty() ? "" : "echo $$ > " + cgroup + "/cgroup.procs && ";
    base = std::make_unique<Program>(
        "sh", std::vector<std::string>{"-c", join + "exec setsid " + driver_line()},
        file(std::string(kind_.driver) + ".log"));
    EXPECT_TRUE(wait([this] { return status && status->link == BaseStatus::Link::up; }))
        << log(kind_.driver);
  }
  /// The guardian of the base's driver; 0 = there is none.
  pid_t guardian(pid_t driver) const {
    return process(std::string(kind_.driver) + " " + std::to_string(driver) + '\0');
  }
  /// Under procman, where `base` is none; 0 = there is none.
  pid_t driver() const { return process(file("ports/base") + '\0'); }
  /// How procman starts the driver.
  std::string driver_line() const {
    const char* bin = std::getenv("MARCO_BIN");
    return std::string(bin != nullptr ? bin : ".") + "/" + kind_.driver + " --config " +
           kind_.driver_config + " --device " + file("ports/base");
  }
  /// A hand holds the stick of a gamepad.
  void start_gamepad_and_teleop() {
    gamepad.reset();
    teleop.reset();
    close(hand_);
    hand_ = -1;
    teleop = start("marco-teleop", {"--no-keys"});
    gamepad = start("marco-gamepad", {"--device", file("pad")});
    EXPECT_TRUE(wait([this] {
      if (hand_ < 0) hand_ = open(file("pad").c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
      return hand_ >= 0;
    }));
    const auto record =
        drivers::gamepad::encode_event({1, -32767, drivers::gamepad::Event::Kind::axis, false, 0});
    EXPECT_EQ(write(hand_, record.data(), record.size()), 8);
    EXPECT_TRUE(wait([this] { return turns(); })) << log(kind_.driver);
  }
  void end_all_but_simulator() {
    gamepad.reset();
    teleop.reset();
    base.reset();
  }
  ~DrivenRobot() { close(hand_); }

  /// @returns its id.
  int64_t publish(BaseCommand::Kind kind) {
    BaseCommand command;
    command.kind = kind;
    command.utime = drivers::wall_now();
    command.id = command.utime.us;
    command.yaw_rate_rad_per_s = 0.4;
    command.angle_rad = 3.0;
    command.distance_m = 30.0;
    bus_.publish(channels::kBaseCommand, to_message(command));
    return command.id;
  }
  /// Turns for so long, by orders of this test.
  void drive(double seconds) {
    Utime next;
    wait(
        [&] {
          if (drivers::wall_now() >= next) publish(BaseCommand::Kind::velocity);
          if (drivers::wall_now() >= next) next = drivers::wall_now() + Duration::from_us(100'000);
          return false;
        },
        seconds);
  }
  void publish(bool engaged, const std::string& sender) {
    bus_.publish(channels::kEmergencyStop,
                 to_message(EmergencyStop{drivers::wall_now(), engaged, sender, "a test"}));
  }
  bool says(const std::string& text) const { return status && status->note.find(text) == 0; }
  void publish(const SensorInfo& info) { bus_.publish(channels::kSensorInfo, to_message(info)); }
  /// The cable of the base is out for so long.
  void pull_cable(double seconds) {
    sim_fault_t fault{};
    fault.device = "base";
    fault.kind = "unplugged";
    fault.duration_s = seconds;
    bus_.publish(channels::kSimFault, fault);
  }

  const TruePose& truth() const { return *truth_; }
  bool turns() const { return moved_ && (truth_->utime - *moved_).seconds() < 0.2; }
  bool rests() const { return !moved_ || (truth_->utime - *moved_).seconds() > 1.5; }
  bool wait(const std::function<bool()>& done, double seconds = kPatienceS) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end && !done()) bus_.handle_once(10);
    return done();
  }
  /// @param dies  ends what drives the robot. @returns how long the wheels turned after it [s], and
  /// `way_rad` how far; infinity when they still turn after `patience_s`.
  double stopping_s(const std::function<void()>& dies, double patience_s = kPatienceS) {
    EXPECT_TRUE(wait([this] { return turns(); })) << "it did not turn before";
    wait([] { return false; }, 0.05);
    const Utime since = drivers::wall_now();
    const double from_rad = turned_rad_;
    dies();
    // Poses of before may wait in a buffer.
    const bool stopped = wait([&] { return truth_->utime > since && rests(); }, patience_s);
    way_rad = turned_rad_ - from_rad;
    if (!stopped) return std::numeric_limits<double>::infinity();
    return std::max(0.0, (*moved_ - since).seconds());
  }

  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string log(const std::string& program) const {
    std::ifstream in(file(program + ".log"));
    return {std::istreambuf_iterator<char>(in), {}};
  }

  std::unique_ptr<Program> base, gamepad, teleop;
  std::optional<BaseStatus> status;
  double way_rad = 0.0;

 private:
  /// The process whose command line has this; 0 = none.
  static pid_t process(const std::string& part) {
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      std::ifstream in(entry.path() / "cmdline");
      const std::string line{std::istreambuf_iterator<char>(in), {}};
      if (line.find(part) != line.npos) return std::atoi(entry.path().filename().c_str());
    }
    return 0;
  }
  void on_truth(const TruePose& pose) {
    if (truth_) {
      const double turned_rad =
          normalize_angle(pose.world_from_robot.theta_rad - truth_->world_from_robot.theta_rad);
      turned_rad_ += std::abs(turned_rad);
      if (std::abs(turned_rad) > 1e-4) moved_ = pose.utime;
    }
    truth_ = pose;
  }

  Kind kind_;
  TemporaryFolder folder_;
  process::LcmBus bus_;
  process::DropCounter drops_;
  std::unique_ptr<Program> simulator_;
  std::optional<TruePose> truth_;
  std::optional<Utime> moved_;  ///< when it was last seen to turn
  double turned_rad_ = 0.0;
  int hand_ = -1;
};

}  // namespace marco::testing
