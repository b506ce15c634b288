// Programs that hear nothing say so: what they wait for, what is there instead, what to do.
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>

#include "bot_core/planar_lidar_t.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/odometry_t.hpp"
#include "marco/process_status_t.hpp"
#include "simulator/devices/transport/emulator.hpp"
#include "simulator/devices/transport/emulator_port.hpp"

namespace marco {
namespace {

using ::marco::testing::Program;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kPatienceS = 60.0;  // a few seconds, on a machine that is not busy

/// Programs, what they print, what they say on PROCESS_STATUS, and messages at 20 Hz.
class Silence : public ::testing::Test {
 protected:
  Silence() : bus_("") {
    bus_.subscribe<process_status_t>(
        channels::kProcessStatus, heard_,
        [this](const auto& status, const auto&) { states_[status.process] = status.state; });
  }
  void start(const std::string& name, std::vector<std::string> arguments = {}) {
    programs_[name] = std::make_unique<Program>(name, std::move(arguments), file(name));
  }
  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string printed(const std::string& name) const {
    return std::filesystem::exists(file(name)) ? files::read_whole_file(file(name)) : "";
  }
  // Whether `name` prints `text` in time; sends meanwhile.
  bool prints(const std::string& name, const std::string& text) {
    return comes([&] { return printed(name).find(text) != std::string::npos; });
  }
  bool says(const std::string& name, const std::string& text) {
    return comes([&] { return states_[name].find(text) != std::string::npos; });
  }
  bool comes(const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kPatienceS);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) return false;
      if (send) send();
      for (int i = 0; i < 10; ++i) bus_.handle_once(5);
      if (serve) serve();
    }
    return true;
  }
  template <class Message>
  void publish(const std::string& channel) {
    Message message = {};
    message.utime = drivers::wall_now().us;
    bus_.publish(channel, message);
  }

  std::function<void()> send, serve;
  process::LcmBus bus_;
  process::DropCounter heard_;
  std::map<std::string, std::string> states_;
  TemporaryFolder folder_;
  std::map<std::string, std::unique_ptr<Program>> programs_;
};

TEST_F(Silence, OnAnEmptyBusAndTheEndOfIt) {
  start("marco-slam");
  start("marco-line-slam");
  start("marco-mapping3d");
  EXPECT_TRUE(prints("marco-slam", "waiting for scans: nothing on LIDAR or LIDAR_RAW for"));
  EXPECT_TRUE(prints("marco-slam", "Start a laser"));
  EXPECT_TRUE(prints("marco-line-slam", "waiting for scans: nothing on LIDAR or LIDAR_RAW for"));
  EXPECT_TRUE(prints("marco-mapping3d", "waiting for a laser on a pan-tilt: nothing on"));
  EXPECT_TRUE(says("marco-slam", "waiting for scans; "));
  // Told once: the next time is a minute later.
  const std::string once = printed("marco-slam");
  EXPECT_EQ(once.find("waiting for scans"), once.rfind("waiting for scans"));
  send = [this] {
    publish<bot_core::planar_lidar_t>("LIDAR");
    publish<odometry_t>("ODOMETRY");
  };
  // Without SENSOR_INFO nobody can use them.
  EXPECT_TRUE(prints("marco-slam", "but all are dropped: no SENSOR_INFO for LIDAR"));
  EXPECT_THAT(printed("marco-slam"), Not(HasSubstr("no odometry")));
  send = nullptr;
  EXPECT_TRUE(prints("marco-slam", "no more messages on LIDAR (scans): the last came 1"));
}

TEST_F(Silence, WhileAnotherRobotsChannelSpeaks) {
  send = [this] { publish<bot_core::planar_lidar_t>("RPLIDAR_LASER"); };
  start("marco-slam");
  EXPECT_TRUE(prints("marco-slam", "On this bus: RPLIDAR_LASER"));
  EXPECT_TRUE(prints("marco-slam", "(bot_core.planar_lidar_t)"));
  EXPECT_TRUE(prints("marco-slam", "RPLIDAR_LASER carries scans under another name"));
}

TEST_F(Silence, WhileTheChannelCarriesAnotherType) {
  send = [this] { publish<odometry_t>("LIDAR"); };
  start("marco-slam");
  EXPECT_TRUE(prints("marco-slam", "waiting for scans: LIDAR carries marco.odometry_t, not"));
}

// A device that says `text` ten times a second, whatever it is asked.
class Chatter final : public drivers::Emulator {
 public:
  explicit Chatter(std::string text) : text_(std::move(text)) {}
  void receive(std::span<const uint8_t>, int, Utime) override {}
  void advance(Utime now, std::vector<uint8_t>& out) override {
    if (now < next_) return;
    next_ = now + Duration::from_us(100'000);
    out.insert(out.end(), text_.begin(), text_.end());
  }
  Utime next_event() const override { return next_; }
  void on_connection(bool, Utime) override {}

 private:
  std::string text_;
  Utime next_;
};

TEST_F(Silence, OfDevices) {
  Chatter mute(""), gps("$GPGGA,123519,4807.038,N*47\r\n");
  drivers::EmulatorPort mute_port = drivers::EmulatorPort::pty(mute);
  drivers::EmulatorPort gps_port = drivers::EmulatorPort::pty(gps);
  std::array<drivers::EmulatorPort*, 2> ports{&mute_port, &gps_port};
  serve = [&ports] { serve_ports(ports, Duration::from_us(1000)); };
  start("marco-slam");
  start("marco-sick", {"--device", "/dev/ttyUSB77"});
  start("marco-rplidar", {"--device", mute_port.address()});
  start("marco-imu", {"--device", gps_port.address()});
  start("marco-gamepad", {"--device", "/dev/input/js77"});
  start("marco-camera", {"--device", "77"});
  EXPECT_TRUE(prints("marco-sick", "no device: /dev/ttyUSB77: no such device"));
  EXPECT_TRUE(says("marco-sick", "no device: /dev/ttyUSB77"));
  EXPECT_TRUE(prints("marco-gamepad", "no device: /dev/input/js77: no such device"));
  EXPECT_TRUE(prints("marco-camera", "no device: /dev/video77: no such device"));
  EXPECT_TRUE(prints("marco-rplidar", "no bytes at all from " + mute_port.address()));
  EXPECT_TRUE(says("marco-rplidar", "no device answers: no bytes at all"));
  EXPECT_TRUE(prints("marco-imu", "make no telegram: 24 47 50 47 47 41"));
  EXPECT_TRUE(says("marco-imu", "a GPS receiver?"));
  // Who waits for the laser passes on what its driver says.
  EXPECT_TRUE(prints("marco-slam", "marco-sick: no device: /dev/ttyUSB77"));
  const std::string once = printed("marco-sick");
  EXPECT_EQ(once.find("no device"), once.rfind("no device")) << once;
}

class Refused : public Silence {
 protected:
  // @returns the exit code.
  int run(const std::string& name, std::vector<std::string> arguments) {
    start(name, std::move(arguments));
    return programs_[name]->wait(kPatienceS);
  }
};

TEST_F(Refused, OptionsBeforeThePortIsOpened) {
  const auto refuses = [this](const std::string& name, const std::string& config) {
    folder_.write("x.toml", config);
    EXPECT_EQ(run(name, {"--config", file("x.toml"), "--device", "/dev/ttyUSB77"}), 1) << config;
    return printed(name);
  };
  EXPECT_THAT(refuses("marco-rplidar", "[rplidar]\nbaud = 57600\n"),
              HasSubstr("115200 (A1, A2), 256000"));
  EXPECT_THAT(refuses("marco-rplidar", "[rplidar]\nmode = \"boost\"\n"),
              HasSubstr("'express' or 'standard'"));
  EXPECT_THAT(refuses("marco-sick", "[sick]\nresolution_deg = 0.25\n"),
              HasSubstr("100 by 1, 0.5 or 0.25 deg"));
  EXPECT_NE(run("marco-sick", {"--device", ""}), 0);
  EXPECT_THAT(printed("marco-sick"), HasSubstr("give a path, or tcp:HOST:PORT"));
}

TEST_F(Refused, ABusWhosePortIsNotShared) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in any = {};
  any.sin_family = AF_INET;
  any.sin_port = htons(7999);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&any), sizeof any), 0);
  EXPECT_EQ(run("marco-slam", {"--lcm-url", "udpm://239.255.76.67:7999?ttl=0"}), 1);
  ::close(socket);
  EXPECT_THAT(printed("marco-slam"), HasSubstr("UDP port 7999 is held by silence_process_test ("));
}

TEST_F(Refused, ToDriveWithoutATerminalAndATourWithoutABase) {
  EXPECT_EQ(std::system(("$MARCO_BIN/marco-teleop </dev/null >" + file("drive") + " 2>&1").c_str()),
            1 << 8);
  EXPECT_THAT(printed("drive"), HasSubstr("standard input is not a terminal"));
  EXPECT_EQ(run("marco-tour", {"config/tours/sample.toml"}), 1);
  EXPECT_THAT(printed("marco-tour"), HasSubstr("waiting for the base: nothing on BASE_STATUS"));
}

}  // namespace
}  // namespace marco
