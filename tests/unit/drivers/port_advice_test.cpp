#include "drivers/transport/port_advice.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

#include "drivers/transport/serial_stream.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "simulator/devices/transport/emulator.hpp"
#include "simulator/devices/transport/emulator_port.hpp"

namespace marco::drivers {
namespace {

using ::marco::testing::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(OpenFailure, AMissingPortIsToldWithThosePresent) {
  OpenFailure failure;
  failure.path = "/dev/ttyUSB0";
  failure.error = ENOENT;
  EXPECT_THAT(open_failure_text(failure), HasSubstr("no serial ports are plugged in: are cable"));
  failure.seen = {{"/dev/ttyACM0", "/dev/serial/by-id/usb-Hokuyo-if00"}, {"/dev/ttyUSB1", ""}};
  EXPECT_EQ(open_failure_text(failure),
            "/dev/ttyUSB0: no such device; serial ports here: /dev/ttyACM0 "
            "(/dev/serial/by-id/usb-Hokuyo-if00), /dev/ttyUSB1. Give one with --device");
  failure.path = "out/run/ports/laser";
  EXPECT_THAT(open_failure_text(failure), HasSubstr("marco-sim"));
}

TEST(OpenFailure, AForbiddenPortIsToldWithItsGroup) {
  OpenFailure failure;
  failure.path = "/dev/ttyUSB0";
  failure.error = EACCES;
  failure.group = "dialout";
  EXPECT_EQ(open_failure_text(failure),
            "/dev/ttyUSB0: permission denied: it belongs to the group dialout. Add yourself: `sudo "
            "usermod -aG dialout $USER`, then log in again");
  failure.group = "root";
  EXPECT_THAT(open_failure_text(failure), Not(HasSubstr("usermod")));
}

TEST(OpenFailure, APortInUseIsToldWithItsHolderAndOthersWithTheSystemsWord) {
  OpenFailure failure;
  failure.path = "/dev/ttyUSB0";
  failure.error = EBUSY;
  failure.holder = "minicom (4711)";
  EXPECT_EQ(open_failure_text(failure), "/dev/ttyUSB0: held by minicom (4711)");
  failure.holder.clear();
  EXPECT_EQ(open_failure_text(failure), "/dev/ttyUSB0: held by another process");
  failure.error = EIO;
  EXPECT_THAT(open_failure_text(failure), HasSubstr("nput/output error"));
}

TEST(DevicesSeen, AreThosePluggedInWithTheirLastingNames) {
  const TemporaryFolder dev;
  std::filesystem::create_directories(dev.path() / "serial/by-id");
  std::filesystem::create_directories(dev.path() / "input");
  for (const char* name : {"ttyUSB1", "ttyACM0", "ttyS0", "null", "input/js0", "input/mouse0"}) {
    dev.write(name, "");
  }
  std::filesystem::create_symlink("../../ttyUSB1", dev.path() / "serial/by-id/usb-CP2102");
  const auto serial = devices_seen(DeviceKind::serial, dev.path().string());
  ASSERT_EQ(serial.size(), 2U);
  EXPECT_EQ(serial[0].path, (dev.path() / "ttyUSB1").string());
  EXPECT_EQ(serial[0].by_id, (dev.path() / "serial/by-id/usb-CP2102").string());
  EXPECT_EQ(serial[1].path, (dev.path() / "ttyACM0").string());
  EXPECT_EQ(serial[1].by_id, "");
  EXPECT_EQ(devices_seen(DeviceKind::gamepad, dev.path().string()).size(), 1U);
  EXPECT_TRUE(devices_seen(DeviceKind::camera, dev.path().string()).empty());
}

class Mute final : public Emulator {
 public:
  void receive(std::span<const uint8_t>, int, Utime) override {}
  void advance(Utime, std::vector<uint8_t>&) override {}
  Utime next_event() const override { return Utime::from_us(INT64_MAX); }
  void on_connection(bool, Utime) override {}
};

TEST(SerialPort, ThatAnotherProcessHoldsIsRefusedWithItsName) {
  Mute device;
  EmulatorPort port = EmulatorPort::pty(device);
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t holder = fork();
  if (holder == 0) {
    const int fd = open(port.address().c_str(), O_RDWR | O_NOCTTY);
    flock(fd, LOCK_EX);
    if (write(ready[1], "x", 1) != 1) _exit(1);
    pause();
    _exit(0);
  }
  char byte;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  std::string why;
  try {
    open_stream(port.address(), {9600});
  } catch (const std::invalid_argument& refused) {
    why = refused.what();
  }
  kill(holder, SIGKILL);
  EXPECT_THAT(why, HasSubstr(": held by "));
  EXPECT_THAT(why, HasSubstr("(" + std::to_string(holder) + ")"));
}

}  // namespace
}  // namespace marco::drivers
