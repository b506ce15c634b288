// The process that all bases' drivers are, by the Kobuki's: on a pseudo-terminal whose other end is
// its emulator, and real LCM.
#include <gmock/gmock.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "marco/odometry_t.hpp"
#include "marco/process_status_t.hpp"
#include "simulator/devices/kobuki/emulator.hpp"
#include "simulator/devices/transport/emulator_port.hpp"

extern char** environ;

namespace marco::drivers {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using Fate = BaseStatus::Command;
using Kind = BaseCommand::Kind;

// What takes a second may take this long on a machine that stands still now and then.
constexpr double kPatienceS = 30.0;

class BaseDriverProcess : public ::testing::Test {
 protected:
  BaseDriverProcess() {
    std::string pattern = (std::filesystem::temp_directory_path() / "baseXXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    setenv("XDG_STATE_HOME", folder_.c_str(), 1);
    std::ofstream(folder_ / "kobuki.toml")
        << "device = \"" << (folder_ / "base").string() << "\"\n";
    bus_.subscribe_raw(".*", [this](const process::RawMessage& raw) { take(raw); });
  }
  ~BaseDriverProcess() override {
    end(SIGKILL);
    std::filesystem::remove_all(folder_);
  }
  void plug_in() { port_.emplace(EmulatorPort::pty(robot_, (folder_ / "base").string())); }
  void start() {
    const char* bin = std::getenv("MARCO_BIN");
    const std::string program =
        std::string(bin != nullptr ? bin : "build/dev/bin") + "/marco-kobuki";
    std::vector<std::string> words{program, "--config", (folder_ / "kobuki.toml").string(),
                                   "--log-level", "off"};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ASSERT_EQ(posix_spawn(&pid_, program.c_str(), nullptr, nullptr, arguments.data(), environ), 0);
  }
  /// @returns its exit code.
  int end(int signal) {
    if (pid_ <= 0) return 0;
    kill(pid_, signal);
    int status = 0;
    waitpid(std::exchange(pid_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  bool run_until(const std::function<bool()>& done, double limit_s = kPatienceS) {
    const Utime limit = wall_now() + Duration::from_seconds(limit_s);
    while (!done() && wall_now() < limit) {
      if (port_) {
        std::array<EmulatorPort*, 1> ports{&*port_};
        serve_ports(ports, Duration::from_us(1000));
      }
      while (bus_.handle_once(port_ ? 0 : 5)) {
      }
      if (scans_ && wall_now() > next_scan_) look();
    }
    return done();
  }
  void run(double seconds) {
    run_until([] { return false; }, seconds);
  }
  /// Given again where it came too late, or where the driver or a scan did: a machine may be busy.
  bool obeyed(Kind kind, double amount, Fate fate) {
    BaseCommand command;
    return run_until([&] {
      const bool late =
          status_.command_id == command.id && status_.command != fate &&
          (status_.note.find("s old") != std::string::npos || status_.command == Fate::aborted);
      if (command.id == 0 || late) {
        command.utime = wall_now();
        command.id = command.utime.us;
        command.kind = kind;
        command.distance_m = amount;
        bus_.publish(channels::kBaseCommand, to_message(command));
      }
      return status_.command_id == command.id && status_.command == fate;
    });
  }
  void stop(bool engaged) {
    bus_.publish(channels::kEmergencyStop,
                 to_message(EmergencyStop{wall_now(), engaged, "sheriff", "a child"}));
  }
  bool is_up() const { return status_.link == BaseStatus::Link::up; }
  bool moves() const { return std::abs(robot_.left_m_per_s()) > 0.01; }

  std::filesystem::path folder_;
  kobuki::KobukiEmulator robot_;
  std::optional<EmulatorPort> port_;
  process::LcmBus bus_{""};
  BaseStatus status_;
  std::map<std::string, int> counts_;
  std::string state_;
  double odometry_m_ = 0.0;  ///< ahead, as published last
  bool scans_ = false;       ///< a laser looks at walls far away

 private:
  void take(const process::RawMessage& raw) {
    const std::string channel(raw.channel);
    ++counts_[channel];
    const int size = static_cast<int>(raw.bytes.size());
    base_status_t base;
    process_status_t process;
    odometry_t odometry;
    if (channel == channels::kBaseStatus && base.decode(raw.bytes.data(), 0, size) > 0) {
      status_ = from_message(base);
    }
    if (channel == channels::kOdometry && odometry.decode(raw.bytes.data(), 0, size) > 0) {
      odometry_m_ = odometry.x_m;
    }
    if (channel == channels::kProcessStatus && process.decode(raw.bytes.data(), 0, size) > 0) {
      state_ = process.state;
    }
  }
  void look() {
    next_scan_ = wall_now() + Duration::from_seconds(0.1);
    SensorInfo info;
    info.utime = wall_now();
    info.parent_from_sensor.translation().z() = 0.3;
    bus_.publish(channels::kSensorInfo, to_message(info));
    LaserScan scan;
    scan.utime = wall_now();
    scan.first_bearing_rad = -std::numbers::pi;
    scan.bearing_step_rad = deg_to_rad(2.0);
    scan.ranges_m.assign(180, 8.0F);
    bus_.publish(channels::kLidar, to_message(scan));
  }
  pid_t pid_ = -1;
  Utime next_scan_;
};

TEST_F(BaseDriverProcess, WithoutADeviceRefusesOrdersAndDrivesNoneOfThemLater) {
  start();
  ASSERT_TRUE(run_until([&] { return counts_[channels::kProcessStatus] > 0; }));
  EXPECT_TRUE(obeyed(Kind::move, 0.3, Fate::refused));
  EXPECT_THAT(status_.note, StartsWith("the base does not answer"));
  EXPECT_EQ(status_.link, BaseStatus::Link::down);
  const int before = counts_[channels::kBaseStatus];
  EXPECT_TRUE(run_until([&] { return counts_[channels::kBaseStatus] > before + 2; }))
      << "it is published although nothing is ordered";
  EXPECT_EQ(status_.base, "kobuki");
  // What was ordered before the device was there is not driven.
  plug_in();
  ASSERT_TRUE(run_until([&] { return is_up(); }));
  run(0.5);
  EXPECT_FALSE(moves());
  EXPECT_EQ(end(SIGTERM), 0);
}

TEST_F(BaseDriverProcess, DrivesByWhatLasersSeeAndStopsWithItsProcess) {
  plug_in();
  start();
  ASSERT_TRUE(run_until([&] { return is_up() && counts_[channels::kOdometry] > 10; }));
  EXPECT_THAT(status_.note, HasSubstr("no laser or sonar data"));
  scans_ = true;
  ASSERT_TRUE(run_until([&] { return status_.note.find("guard:") == std::string::npos; }))
      << status_.note;
  EXPECT_TRUE(obeyed(Kind::move, 0.2, Fate::done)) << status_.note;
  EXPECT_GT(robot_.left_m(), 0.18);
  ASSERT_TRUE(run_until([&] { return std::abs(odometry_m_ - robot_.left_m()) < 0.002; }))
      << odometry_m_ << " of " << robot_.left_m() << " m";
  EXPECT_GT(counts_[channels::kImu], 10) << "of its gyro";
  EXPECT_TRUE(run_until([&] { return state_.find("kobuki ready") != std::string::npos; }))
      << state_;
  EXPECT_TRUE(obeyed(Kind::move, 2.0, Fate::running));
  ASSERT_TRUE(run_until([&] { return moves(); }));
  EXPECT_EQ(end(SIGTERM), 0);
  run(0.5);
  EXPECT_FALSE(moves());
}

TEST_F(BaseDriverProcess, AnEmergencyStopHoldsBeyondItsDriver) {
  plug_in();
  start();
  ASSERT_TRUE(run_until([&] { return is_up(); }));
  EXPECT_TRUE(obeyed(Kind::move, 2.0, Fate::running));
  ASSERT_TRUE(run_until([&] { return moves(); }));
  stop(true);
  ASSERT_TRUE(run_until([&] { return !moves(); }));
  ASSERT_TRUE(run_until([&] { return status_.command == Fate::aborted; }));
  EXPECT_THAT(status_.note, StartsWith("emergency stop by sheriff: a child"));
  EXPECT_EQ(end(SIGTERM), 0);
  status_ = {};
  start();
  ASSERT_TRUE(run_until([&] { return is_up(); }));
  EXPECT_THAT(status_.note, StartsWith("emergency stop by sheriff: a child"));
  EXPECT_TRUE(obeyed(Kind::move, 0.3, Fate::refused));
  stop(false);
  ASSERT_TRUE(run_until([&] { return status_.note.find("emergency") != 0; }));
  EXPECT_TRUE(obeyed(Kind::move, 0.1, Fate::done));
  EXPECT_EQ(end(SIGTERM), 0);
}

// The line is pulled and put back; a driver that is killed leaves the stopping to its guardian.
TEST_F(BaseDriverProcess, ALostLineAndAKilledDriverStopTheWheels) {
  plug_in();
  start();
  ASSERT_TRUE(run_until([&] { return is_up(); }));
  port_->unplug();
  ASSERT_TRUE(run_until([&] { return status_.link == BaseStatus::Link::down; }));
  port_->plug_in();
  ASSERT_TRUE(run_until([&] { return is_up(); }));
  EXPECT_TRUE(obeyed(Kind::move, 2.0, Fate::running));
  ASSERT_TRUE(run_until([&] { return moves(); }));
  end(SIGKILL);
  EXPECT_TRUE(run_until([&] { return !moves(); }, 3.0));
}

}  // namespace
}  // namespace marco::drivers
