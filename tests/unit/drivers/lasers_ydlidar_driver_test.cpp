#include <gmock/gmock.h>

#include <algorithm>

#include "drivers/ydlidar/driver.hpp"
#include "simulator/devices/ydlidar/emulator.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::ydlidar {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct Rig {
  explicit Rig(const YdlidarEmulatorOptions& device = {}, const YdlidarOptions& options = {})
      : emulator(test_world, device),
        line(emulator),
        stream(line.open({9600})),
        driver(*stream, options, [this] { return line.now(); }) {}
  std::vector<ArrivedScan> run(double limit_s, std::size_t count) {
    return step_until(driver, line, limit_s, have(count));
  }
  YdlidarEmulator emulator;
  SimulatedLine line;
  std::unique_ptr<ByteStream> stream;
  YdlidarDriver driver;
};

// Angles are rounded to 1/64 deg (3 m/rad of the test world: 0.4 mm), ranges to 1 mm at worst, and
// the world moves by 3.5 m/s, so that 0.3 ms of timing make 1 mm.
constexpr double kToleranceM = 0.0004 + 0.0005 + 0.001;

TEST(YdlidarDriver, KnowsEachFamilyByWhatArrives) {
  YdlidarEmulatorOptions with_intensity = g4(), time_of_flight = g4();
  with_intensity.intensity_bytes = 1;
  with_intensity.samples_per_s = 4000.0;  // what the line carries
  time_of_flight.intensity_bytes = 2;
  time_of_flight.baud = 512'000;
  for (const auto& [device, said] :
       {std::pair{YdlidarEmulatorOptions{}, "X4, 128000 baud"},
        std::pair{x2(), "receives nothing, 115200 baud"}, std::pair{g4(), "G4, 230400 baud"},
        std::pair{with_intensity, "G4, 230400 baud"},
        std::pair{time_of_flight, "G4, 512000 baud"}}) {
    Rig rig(device);
    const auto scans = rig.run(9.0, 20);
    ASSERT_EQ(scans.size(), 20u) << said << ": " << rig.driver.state();
    EXPECT_THAT(rig.driver.state(), HasSubstr(said));
    for (const ArrivedScan& arrived : scans) {
      EXPECT_NEAR(static_cast<double>(arrived.scan.size()),
                  device.samples_per_s / device.turns_per_s, 1.0);
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM) << said;
      ASSERT_EQ(arrived.intensities.size(), arrived.scan.size());
      EXPECT_EQ(arrived.intensities[0], device.intensity_bytes > 0 ? 200.0F : 0.0F);
    }
    EXPECT_EQ(rig.driver.counts().dropped(), 0) << said;
  }
}

// Its own look is beside its light by seven degrees: without the correction the room turns.
TEST(YdlidarDriver, TheCorrectionOfAnglesIsNeeded) {
  YdlidarOptions options;
  options.angle_correction = false;
  Rig rig({}, options);
  const auto scans = rig.run(6.0, 2);
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_GT(worst_range_error_m(scans[1].scan), 0.2);
}

TEST(YdlidarDriver, LearnsAnyPeriod) {
  YdlidarEmulatorOptions device;
  device.samples_per_s = 4420.0;
  Rig rig(device);
  const auto scans = rig.run(20.0, 80);
  ASSERT_EQ(scans.size(), 80u);
  EXPECT_LT(worst_range_error_m(scans.front().scan), kToleranceM);
  EXPECT_LT(worst_range_error_m(scans.back().scan), kToleranceM);
}

// Learned while the host stood still, by bytes that came all at once: noticed, and learned again.
TEST(YdlidarDriver, APeriodLearnedWrongIsLearnedAgain) {
  Rig rig;
  while (!rig.driver.measuring()) rig.driver.step();
  rig.line.wait(Duration::from_seconds(1.6));
  rig.run(12.0, 70);
  const auto scans = rig.run(8.0, 20);
  ASSERT_EQ(scans.size(), 20u);
  for (const ArrivedScan& arrived : scans) {
    EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM);
  }
}

TEST(YdlidarDriver, NothingIsZeroAndErrorsAreReported) {
  YdlidarEmulatorOptions device;
  device.range_max_m = 3.0;
  Rig rig(device);
  const auto scans = rig.run(6.0, 2);
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_GT(std::count(scans[1].scan.ranges_m.begin(), scans[1].scan.ranges_m.end(), 0.0f), 100);
  for (YdlidarEmulatorOptions ill : {YdlidarEmulatorOptions{}, g4()}) {  // each has its own request
    ill.health = 2;
    Rig in_trouble(ill);
    EXPECT_TRUE(in_trouble.run(4.0, 1).empty());
    EXPECT_THAT(in_trouble.driver.state(), HasSubstr("reports error"));
  }
}

// Left scanning by a program that died: told to stop, it answers.
TEST(YdlidarDriver, FindsALaserThatIsScanning) {
  Rig rig;
  ASSERT_EQ(rig.run(6.0, 3).size(), 3u);
  YdlidarDriver second(*rig.stream, {}, [&] { return rig.line.now(); });
  EXPECT_EQ(step_until(second, rig.line, 6.0, have(3)).size(), 3u);
  EXPECT_THAT(second.state(), HasSubstr("X4"));
  EXPECT_THAT(second.state(), Not(HasSubstr("receives nothing")));
  second.stop();
  rig.line.wait(Duration::from_seconds(0.1));
  rig.stream->discard_input();
  uint8_t buffer[100];
  EXPECT_EQ(rig.stream->read(buffer, std::chrono::milliseconds(200)), 0u) << "it still scans";
}

// The sum is an exclusive or: two flips of the same bit in a packet escape it, so there is one.
TEST(YdlidarDriver, LostPacketsLeaveTheOthersTheirTimes) {
  for (const YdlidarEmulatorOptions& device : {YdlidarEmulatorOptions{}, x2(), g4()}) {
    Rig rig(device);
    ASSERT_EQ(rig.run(6.0, 15).size(), 15u);
    std::mt19937 random(8);
    int whole = 0;
    rig.line.set_tamper_to_client([&](Bytes& bytes) {
      const auto kind = random() % 300;
      if (++whole < 10 || kind > 5) return;
      whole = 0;
      if (kind < 2) bytes[random() % bytes.size()] ^= static_cast<uint8_t>(1 << random() % 8);
      if (kind == 3) bytes.erase(bytes.begin());
      if (kind == 4) bytes.insert(bytes.begin(), bytes[0]);
      if (kind == 5) bytes.clear();
    });
    const auto scans = rig.run(20.0, 1000);
    EXPECT_GT(scans.size(), 100u);
    EXPECT_GT(rig.driver.counts().drops.at("lost_samples"), 20);
    for (const ArrivedScan& arrived : scans) {
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM) << device.samples_per_s;
    }
  }
}

}  // namespace
}  // namespace marco::drivers::ydlidar
