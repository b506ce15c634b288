#include <gtest/gtest.h>

#include <random>

#include "bench.hpp"
#include "common/pose2.hpp"
#include "drivers/bno055/driver.hpp"
#include "simulator/devices/bno055/emulator.hpp"

namespace marco::drivers::bno055 {
namespace {

// The data sheet's frames.
TEST(Bno055Codec, RequestsAndReplies) {
  EXPECT_EQ(read_request(Register::chip_id, 1), (Bytes{0xAA, 0x01, 0x00, 0x01}));
  EXPECT_EQ(write_request(Register::mode, 8), (Bytes{0xAA, 0x00, 0x3D, 0x01, 0x08}));
  RequestParser requests;
  requests.push(Bytes{0x00, 0xAA, 0x05, 0xAA, 0x01, 0x14, 0x14, 0xAA, 0x00, 0x3D, 0x01, 0x08});
  auto request = requests.next();
  ASSERT_TRUE(request.has_value());
  EXPECT_FALSE(request->write);
  EXPECT_EQ(request->first, 0x14);
  EXPECT_EQ(request->count, 20u);
  request = requests.next();
  ASSERT_TRUE(request.has_value());
  EXPECT_TRUE(request->write);
  EXPECT_EQ(request->data, Bytes{8});
  EXPECT_FALSE(requests.next().has_value());

  ReplyParser replies;
  replies.expect(1);
  for (const uint8_t byte : Bytes{0x42, 0xBB, 0x02, 0xBB, 0x01}) replies.push({&byte, 1});
  EXPECT_FALSE(replies.next().has_value());
  replies.push(Bytes{kChipId, 0xEE, 0x07});
  EXPECT_EQ(replies.next()->data, Bytes{kChipId});
  EXPECT_EQ(replies.next()->status, kOverrun);
  EXPECT_EQ(replies.garbage_bytes(), 3);
}

struct Rig {
  explicit Rig(const Bno055EmulatorOptions& device = {}, const Bno055Options& options = {})
      : sensor(
            [this](Utime) {
              imu::Motion motion;
              motion.rates_rad_per_s.z() = rate;
              return motion;
            },
            device),
        driver(options),
        bench(driver, sensor, kBaud) {}
  double rate = 0.0;
  Bno055Emulator sensor;
  Bno055Driver driver;
  testing::Bench<Bno055Driver> bench;
};

TEST(Bno055Driver, LearnsTheBiasAndFollowsTheTurn) {
  Rig rig;
  rig.bench.run(6.0);
  EXPECT_EQ(rig.sensor.mode(), Mode::fusion);
  EXPECT_NEAR(rad_to_deg(rig.driver.bias_rad_per_s().z()), 0.2, 0.05);
  rig.driver.take_samples();
  rig.rate = 0.5;
  rig.bench.run(4.0);
  const auto samples = rig.driver.take_samples();
  // One in a hundred takes a fifth of a second.
  EXPECT_GT(samples.size(), 280u);
  EXPECT_LT(samples.size(), 401u);
  EXPECT_GT(rig.driver.overruns(), 20);
  double angle = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    angle += samples[i].angular_velocity_rad_per_s.z() *
             (samples[i].utime - samples[i - 1].utime).seconds();
  }
  EXPECT_NEAR(angle, 0.5 * (samples.back().utime - samples.front().utime).seconds(), 0.01);
  EXPECT_NEAR(samples.back().acceleration_m_per_s2.z(), 9.81, 0.01);
}

TEST(Bno055Driver, TurnsWithItsMounting) {
  Bno055EmulatorOptions device;
  device.overrun_part = device.slow_part = device.bias_deg_per_s = 0.0;
  Bno055Options options;
  options.roll_pitch_yaw_deg = {180.0, 0.0, 0.0};
  options.rate_hz = 50;
  Rig rig(device, options);
  rig.rate = 1.0;
  rig.bench.run(4.0);
  const auto samples = rig.driver.take_samples();
  EXPECT_NEAR(static_cast<double>(samples.size()), 4.0 * 50.0, 8.0);
  EXPECT_NEAR(samples.back().angular_velocity_rad_per_s.z(), -1.0, 0.01);
  EXPECT_NEAR(samples.back().acceleration_m_per_s2.z(), -9.81, 0.01);
}

// A brown-out puts it back into its first mode, in which it measures nothing and says so to nobody.
TEST(Bno055Driver, IsBackAfterPlugSilenceAndBrownOut) {
  Rig rig;
  const auto measures_within = [&](double limit_s) {
    rig.driver.take_samples();
    const Utime begin = rig.bench.now();
    std::size_t seen = 0;
    const bool came = rig.bench.run_until(
        limit_s, [&] { return (seen += rig.driver.take_samples().size()) >= 2; });
    std::printf("BNO055: samples again after %.2f s\n", (rig.bench.now() - begin).seconds());
    return came;
  };
  EXPECT_TRUE(measures_within(1.0));
  rig.bench.plug(false);
  rig.bench.run(1.0);
  EXPECT_FALSE(rig.driver.alive());
  rig.bench.plug(true);
  EXPECT_TRUE(measures_within(1.0));

  rig.bench.spoil = [](Bytes& bytes) { bytes.clear(); };
  rig.bench.run(1.0);
  EXPECT_FALSE(rig.driver.alive());
  std::mt19937 random(3);
  rig.bench.spoil = [&random](Bytes& bytes) {
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
  };
  rig.bench.run(3.0);
  rig.bench.spoil = {};
  EXPECT_TRUE(measures_within(2.0));

  for (int i = 0; i < 20; ++i) {
    rig.bench.run(0.05 + 0.013 * i);
    rig.sensor.power_cycle(rig.bench.now());
    rig.bench.run(1.8);  // 0.65 s of starting, a second until the mode is looked at
    EXPECT_EQ(rig.sensor.mode(), Mode::fusion) << i;
    EXPECT_TRUE(measures_within(1.0)) << i;
  }
}

// So short that no answer is missing: its zeros are no measurement.
TEST(Bno055Driver, ABrownOutOfAMomentGivesNoSampleOfZeros) {
  Bno055EmulatorOptions device;
  device.start_s = 0.0;
  Rig rig(device);
  rig.rate = 0.7;
  rig.bench.run(1.0);
  for (int i = 0; i < 50; ++i) {
    rig.sensor.power_cycle(rig.bench.now());
    rig.bench.run(0.5 + 0.003 * i);
    EXPECT_EQ(rig.sensor.mode(), Mode::fusion) << i;
  }
  const auto samples = rig.driver.take_samples();
  EXPECT_GT(samples.size(), 1000u);
  for (const ImuSample& sample : samples) {
    EXPECT_NEAR(sample.acceleration_m_per_s2.z(), 9.81, 0.01);
    EXPECT_NEAR(sample.angular_velocity_rad_per_s.z(), 0.7, 0.02);
  }
}

TEST(Bno055Driver, SaysWhatMayBeWrong) {
  Bno055EmulatorOptions device;
  device.overrun_part = 1.0;
  Rig rig(device);
  rig.bench.run(2.0);
  EXPECT_NE(rig.driver.state().find("the sensor has no time to answer"), std::string::npos);
  Bno055Options wrong;
  wrong.roll_pitch_yaw_deg = {1.0};
  EXPECT_THROW(Bno055Driver{wrong}, std::invalid_argument);
  Bno055Driver silent{Bno055Options{}};
  EXPECT_NE(silent.state().find("is it set to UART"), std::string::npos);
}

}  // namespace
}  // namespace marco::drivers::bno055
