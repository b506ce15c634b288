// A whole robot in processes of their own: simulator, drivers and a tour, joined by
// pseudo-terminals and LCM, in a network that reaches nobody.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"

extern char** environ;

namespace marco {
namespace {

using std::chrono::steady_clock;

// What takes some seconds may take this long on a machine that stands still now and then.
constexpr double kPatienceS = 40.0;

/// A child process; killed at the end whatever happens.
class Child {
 public:
  Child(const std::string& program, std::vector<std::string> arguments, const std::string& log) {
    const char* folder = std::getenv("MARCO_BIN");
    arguments.insert(arguments.begin(),
                     std::string(folder == nullptr ? "." : folder) + "/" + program);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&files, 1, 2);
    EXPECT_EQ(posix_spawn(&pid_, argv[0], &files, nullptr, argv.data(), environ), 0) << argv[0];
    posix_spawn_file_actions_destroy(&files);
  }
  ~Child() {
    if (!status_) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void send(int signal) const { kill(pid_, signal); }
  /// @returns the exit code, once it has ended.
  std::optional<int> ended() {
    int status = 0;
    if (!status_ && waitpid(pid_, &status, WNOHANG) == pid_) {
      status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    return status_;
  }

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
};

class LiveRobotProcesses : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("marco_bases_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    bus_.subscribe_raw(".*", [this](const process::RawMessage& raw) { on_message(raw); });
  }
  void TearDown() override {
    if (HasFailure()) {
      for (const auto& file : std::filesystem::directory_iterator(folder_)) {
        if (file.path().extension() != ".log") continue;
        std::ifstream in(file.path());
        std::cerr << "== " << file.path().filename() << "\n" << in.rdbuf();
      }
    }
    std::filesystem::remove_all(folder_);
  }

  void on_message(const process::RawMessage& raw) {
    const std::string channel(raw.channel);
    ++counts_[channel];
    if (channel == channels::kBaseStatus) {
      base_status_t message;
      if (message.decode(raw.bytes.data(), 0, static_cast<int>(raw.bytes.size())) > 0) {
        base_ = from_message(message);
      }
    } else if (const auto sample = decode_sample(channel, raw.bytes)) {
      if (const auto* truth = std::get_if<TruePose>(&*sample)) truth_ = *truth;
      if (const auto* odometry = std::get_if<OdometrySample>(&*sample)) odometry_ = *odometry;
      if (const auto* scan = std::get_if<LaserScan>(&*sample)) beams_ = scan->size();
      if (const auto* head = std::get_if<PanTiltState>(&*sample)) {
        highest_tilt_rad_ = std::max(highest_tilt_rad_, head->tilt_rad);
      }
    }
  }
  bool wait(double seconds, const std::function<bool()>& done) {
    const auto end = steady_clock::now() + std::chrono::milliseconds(int(seconds * 1000));
    while (steady_clock::now() < end && !done()) bus_.handle_once(20);
    return done();
  }
  std::string log(const std::string& name) const { return folder_ / (name + ".log"); }
  std::string file(const std::string& name) const { return folder_ / name; }
  std::vector<std::string> driver(const std::string& config, const std::string& port) const {
    return {"--config", "config/robots/michoacan/" + config + ".toml", "--device",
            file("ports/" + port)};
  }

  /// A driver says that it hung, which nothing here makes it do.
  bool hung(const char* driver) const {
    return files::read_whole_file(log(driver)).find("this driver hung") != std::string::npos;
  }
  bool machine_stood_still() const { return hung("base") || hung("pantilt"); }

  std::filesystem::path folder_;
  process::LcmBus bus_{""};
  std::map<std::string, int> counts_;
  std::optional<BaseStatus> base_;
  std::optional<TruePose> truth_;
  std::optional<OdometrySample> odometry_;
  std::size_t beams_ = 0;
  double highest_tilt_rad_ = -1.0;
};

TEST_F(LiveRobotProcesses, DriveATour) {
  std::ofstream(file("tour.toml")) << R"(
start_m = [2.0, 3.0]
[[steps]]
to_m = [2.5, 3.0]
[[steps]]
kind = "face"
heading_deg = 20
[[steps]]
kind = "sweep"
tilt_from_deg = -4
tilt_to_deg = 6
rows = 10
)";
  Child sim("marco-sim",
            {"--config", "config/robots/michoacan.toml", "--world", "config/worlds/lab.toml",
             "--tour", file("tour.toml"), "--ports", file("ports")},
            log("sim"));
  ASSERT_TRUE(wait(kPatienceS, [&] { return counts_[channels::kTruePose] > 0; }));
  Child base("marco-base", driver("base", "base"), log("base"));
  Child pantilt("marco-pantilt", driver("pantilt", "pantilt"), log("pantilt"));
  Child sick("marco-sick", driver("sick", "laser"), log("sick"));
  ASSERT_TRUE(wait(kPatienceS, [&] {
    return base_ && base_->link == BaseStatus::Link::up && counts_[channels::kLidar] > 5 &&
           counts_[channels::kPanTiltState] > 0;
  }));
  // A second driver on the same port is refused.
  Child second("marco-base", driver("base", "base"), log("second"));
  ASSERT_TRUE(wait(kPatienceS, [&] { return second.ended().has_value(); }));
  EXPECT_NE(*second.ended(), 0);

  std::optional<int> ended;
  for (int i = 0; i < 3 && ended != 0; ++i) {
    // A machine that stands still for half a second stops the robot, and ends the tour.
    if (ended && !machine_stood_still()) break;
    Child tour("marco-tour", {file("tour.toml"), "--pose", "true"}, log("tour"));
    ASSERT_TRUE(wait(5.0 * kPatienceS, [&] { return tour.ended().has_value(); }));
    ended = tour.ended();
  }
  EXPECT_EQ(ended, 0);
  for (const char* channel : {"LIDAR", "ODOMETRY", "PANTILT_STATE", "SENSOR_INFO", "BASE_STATUS",
                              "PROCESS_STATUS", "TRUE_POSE"}) {
    EXPECT_GT(counts_[channel], 5) << channel;
  }
  EXPECT_EQ(beams_, 361U);
  EXPECT_NEAR(truth_->world_from_robot.x_m, 2.5, 0.13);  // arrives within 0.12 m
  EXPECT_NEAR(rad_to_deg(truth_->world_from_robot.theta_rad), 20.0, 3.5);
  EXPECT_GT(rad_to_deg(highest_tilt_rad_), 5.0);
  EXPECT_NEAR(odometry_->odom_from_robot.x_m, 0.5, 0.13);

  // SIGTERM in mid-move leaves the motors off.
  BaseCommand command;
  command.kind = BaseCommand::Kind::move;
  command.distance_m = 2.0;
  // On a machine that stands still the driver may find an order too old: it is given again.
  ASSERT_TRUE(wait(kPatienceS, [&] {
    const bool refused =
        base_->command_id == command.id && base_->command == BaseStatus::Command::refused;
    if (command.id == 0 || refused) {
      command.utime = drivers::wall_now();
      command.id = command.utime.us;
      bus_.publish(channels::kBaseCommand, to_message(command));
    }
    return base_->command_id == command.id && base_->motors_on;
  }));
  wait(0.7, [] { return false; });
  base.send(SIGTERM);
  ASSERT_TRUE(wait(kPatienceS, [&] { return base.ended().has_value(); }));
  EXPECT_EQ(*base.ended(), 0);
  // What is on the way to a busy machine was measured before.
  const Utime end = drivers::wall_now();
  ASSERT_TRUE(wait(kPatienceS, [&] { return truth_->utime >= end; }));
  const Pose2 stopped_at = truth_->world_from_robot;
  wait(0.5, [] { return false; });
  EXPECT_NEAR(truth_->world_from_robot.x_m, stopped_at.x_m, 0.02);

  sim.send(SIGTERM);
  ASSERT_TRUE(wait(kPatienceS, [&] { return sim.ended().has_value(); }));
  EXPECT_EQ(*sim.ended(), 0);
  EXPECT_FALSE(std::filesystem::exists(file("ports/base")));  // its links go with it
}

/// A robot of config/robots with an LD19, and the driver of its base.
struct SmallRobot {
  const char* name;
  const char* driver;
  const char* config;
  double battery_v;
};
class SmallRobots : public LiveRobotProcesses, public ::testing::WithParamInterface<SmallRobot> {};
INSTANTIATE_TEST_SUITE_P(Bases,
                         SmallRobots,
                         ::testing::Values(SmallRobot{"homemade", "marco-textbase", "textbase",
                                                      7.4},
                                           SmallRobot{"create", "marco-create", "create", 15.0},
                                           SmallRobot{"kobuki", "marco-kobuki", "kobuki", 16.5}),
                         [](const auto& robot) { return std::string(robot.param.name); });

TEST_P(SmallRobots, Drive) {
  const std::string robots = "config/robots/" + std::string(GetParam().name);
  Child sim("marco-sim",
            {"--config", robots + ".toml", "--world", "config/worlds/lab.toml", "--start", "2", "3",
             "0", "--ports", file("ports")},
            log("sim"));
  ASSERT_TRUE(wait(kPatienceS, [&] { return counts_[channels::kTruePose] > 0; }));
  const auto driver_of = [&](const std::string& name, const std::string& port) {
    return std::vector<std::string>{"--config", robots + "/" + name + ".toml", "--device",
                                    file("ports/" + port)};
  };
  Child base(GetParam().driver, driver_of(GetParam().config, "base"), log("base"));
  Child laser("marco-ldlidar", driver_of("ldlidar", "laser"), log("laser"));
  ASSERT_TRUE(wait(kPatienceS, [&] {
    return base_ && base_->link == BaseStatus::Link::up && counts_[channels::kLidar] > 5;
  }));
  EXPECT_NEAR(static_cast<double>(beams_), 450.0, 1.0);
  BaseCommand command;
  command.kind = BaseCommand::Kind::move;
  command.distance_m = 0.5;
  const auto is_done = [&] {
    return command.id != 0 && base_->command_id == command.id &&
           base_->command == BaseStatus::Command::done;
  };
  ASSERT_TRUE(wait(kPatienceS, [&] {
    const bool in_vain = base_->command == BaseStatus::Command::refused ||
                         base_->command == BaseStatus::Command::aborted;  // a process hung
    if (is_done()) wait(0.3, [] { return false; });
    // A driver that a busy machine held drives on until its guardian stops it.
    const bool went_too_far =
        is_done() && hung("base") && std::abs(odometry_->odom_from_robot.x_m - 0.5) > 0.03;
    if (base_->command_id != command.id || command.id == 0 || in_vain || went_too_far) {
      command.distance_m = 0.5 - (odometry_ ? odometry_->odom_from_robot.x_m : 0.0);
      command.utime = drivers::wall_now();
      command.id = command.utime.us;
      bus_.publish(channels::kBaseCommand, to_message(command));
      wait(1.0, [&] { return base_->command_id == command.id; });
      return false;
    }
    return is_done();
  })) << base_->note;
  EXPECT_NEAR(truth_->world_from_robot.x_m, 2.5, 0.2);  // wheels slip by 0.15 m
  EXPECT_NEAR(odometry_->odom_from_robot.x_m, 0.5, 0.03);
  EXPECT_EQ(base_->battery_v, std::vector<double>{GetParam().battery_v});
  base.send(SIGTERM);
  laser.send(SIGTERM);
  ASSERT_TRUE(wait(kPatienceS, [&] { return base.ended() && laser.ended(); }));
  EXPECT_EQ(*base.ended(), 0);
  EXPECT_EQ(*laser.ended(), 0);
  sim.send(SIGTERM);
  ASSERT_TRUE(wait(kPatienceS, [&] { return sim.ended().has_value(); }));
}

}  // namespace
}  // namespace marco
