#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <random>

#include "bench.hpp"
#include "drivers/gamepad/driver.hpp"
#include "drivers/imu/driver.hpp"
#include "simulator/devices/imu/emulator.hpp"

namespace marco::drivers {
namespace {

using gamepad::Event;
using Bytes = std::vector<uint8_t>;

TEST(Gamepad, RecordsAreTheVectorsBothWays) {
  const struct {
    Event event;
    Bytes bytes;
  } vectors[] = {
      {{1000, 0, Event::Kind::axis, true, 0}, {0xE8, 0x03, 0, 0, 0, 0, 0x82, 0}},
      {{1500, 1, Event::Kind::button, false, 1}, {0xDC, 0x05, 0, 0, 1, 0, 1, 1}},
      {{1600, -32767, Event::Kind::axis, false, 1}, {0x40, 0x06, 0, 0, 0x01, 0x80, 2, 1}},
  };
  gamepad::RecordReader reader;
  for (const auto& vector : vectors) {
    EXPECT_EQ(gamepad::encode_event(vector.event), vector.bytes);
    for (const uint8_t byte : vector.bytes) {  // in the finest split
      EXPECT_FALSE(reader.next());
      reader.push({&byte, 1});
    }
    EXPECT_EQ(reader.next(), vector.event);
  }
  EXPECT_EQ(reader.garbage_bytes(), 0);
}

TEST(Gamepad, ALostByteCostsSomeRecordsNotAll) {
  std::mt19937 random(4);
  gamepad::RecordReader reader;
  int read_at_end = 0;
  for (int i = 0; i < 100; ++i) {
    Bytes bytes =
        gamepad::encode_event({static_cast<uint32_t>(1000 + i * 10), static_cast<int16_t>(random()),
                               Event::Kind::axis, false, static_cast<uint8_t>(i % 4)});
    if (i == 20) bytes.erase(bytes.begin() + 3);
    reader.push(bytes);
    while (const auto event = reader.next()) read_at_end += i >= 90 ? 1 : 0;
  }
  EXPECT_GT(reader.garbage_bytes(), 0);
  EXPECT_GE(read_at_end, 9);
}

TEST(Gamepad, AModelKeepsAxesAndButtons) {
  gamepad::GamepadModel model;
  model.apply({0, 16384, Event::Kind::axis, true, 2}, Utime::from_us(1));
  model.apply({0, 1, Event::Kind::button, false, 1}, Utime::from_us(2));
  ASSERT_EQ(model.state().axes.size(), 3U);
  EXPECT_NEAR(static_cast<double>(model.state().axes[2]), 0.5, 1e-4);
  EXPECT_TRUE(model.state().buttons[1]);
  model.disconnect(Utime::from_us(3));
  EXPECT_FALSE(model.state().connected);
  EXPECT_EQ(model.state().axes[2], 0.0F);
  EXPECT_FALSE(model.state().buttons[1]);
}

TEST(Gamepad, AFifoStandsForADevice) {
  const std::string path =
      std::filesystem::temp_directory_path() / ("marco_gamepad_" + std::to_string(getpid()));
  gamepad::GamepadDriver driver(path);
  EXPECT_TRUE(driver.step(0, Utime::from_seconds(10.0)).empty());
  EXPECT_FALSE(driver.open());
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_TRUE(driver.step(0, Utime::from_seconds(11.5)).empty());  // found on the next look
  ASSERT_TRUE(driver.open());
  const int writer = open(path.c_str(), O_WRONLY | O_NONBLOCK);
  const Bytes bytes = gamepad::encode_event({5, -32767, Event::Kind::axis, false, 1});
  ASSERT_EQ(write(writer, bytes.data(), 3), 3);
  EXPECT_TRUE(driver.step(10, Utime::from_seconds(11.6)).empty());
  ASSERT_EQ(write(writer, bytes.data() + 3, 5), 5);
  const auto states = driver.step(100, Utime::from_seconds(11.7));
  ASSERT_EQ(states.size(), 1U);
  EXPECT_EQ(states[0].axes.at(1), -1.0F);
  EXPECT_TRUE(driver.step(0, Utime::from_seconds(11.75)).empty());
  // Held: said again ten times a second, stamped anew.
  const auto again = driver.step(0, Utime::from_seconds(11.81));
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].axes.at(1), -1.0F);
  EXPECT_EQ(again[0].utime, Utime::from_seconds(11.81));
  close(writer);  // the hand lets go of the gamepad
  const auto gone = driver.step(0, Utime::from_seconds(11.9));
  ASSERT_EQ(gone.size(), 1U);
  EXPECT_FALSE(gone[0].connected);
  EXPECT_EQ(gone[0].axes.at(1), 0.0F);
  EXPECT_TRUE(driver.step(0, Utime::from_seconds(13.0)).empty());
  ASSERT_TRUE(driver.open());
  EXPECT_FALSE(driver.leave(Utime::from_seconds(13.0)).has_value());  // nobody was told of it
  const int next = open(path.c_str(), O_WRONLY | O_NONBLOCK);
  ASSERT_EQ(write(next, bytes.data(), 8), 8);
  ASSERT_EQ(driver.step(100, Utime::from_seconds(13.1)).size(), 1U);
  const auto left = driver.leave(Utime::from_seconds(13.2));
  ASSERT_TRUE(left.has_value());
  EXPECT_FALSE(left->connected);
  close(next);
  std::filesystem::remove(path);
}

TEST(ImuCodec, FramesReadBackAndSpoiltOnesDoNot) {
  // 1 g is 2048: 55 51 00 00 00 00 00 08 00 00 AE.
  imu::Frame frame;
  frame.kind = 0x51;
  frame.values = {0, 0, 2048, 0};
  EXPECT_EQ(imu::encode_frame(frame), (Bytes{0x55, 0x51, 0, 0, 0, 0, 0x00, 0x08, 0, 0, 0xAE}));
  EXPECT_NEAR(2048 * imu::kMetresPerS2, imu::kGravity, 1e-12);
  EXPECT_EQ(imu::set_request(imu::Register::rate, *imu::rate_code(100)),
            (Bytes{0xFF, 0xAA, 0x03, 0x09, 0x00}));
  std::mt19937 random(9);
  imu::FrameParser parser;
  int found = 0;
  for (int i = 0; i < 300; ++i) {
    frame.kind = 0x52;
    for (int16_t& value : frame.values) value = static_cast<int16_t>(random());
    Bytes bytes = imu::encode_frame(frame);
    const bool spoilt = i % 10 == 3;
    if (spoilt) bytes[4] = static_cast<uint8_t>(bytes[4] ^ 0x40);
    parser.push(std::span(bytes).first(5));
    parser.push(std::span(bytes).subspan(5));
    while (const auto got = parser.next()) {
      ++found;
      EXPECT_TRUE(*got == frame || spoilt);
    }
  }
  EXPECT_GE(found, 268);
  EXPECT_LE(found, 272);
}

TEST(ImuDriver, LearnsTheBiasAndFollowsTheTurn) {
  double rate = 0.0;
  imu::ImuEmulator sensor([&rate](Utime) {
    imu::Motion motion;
    motion.rates_rad_per_s.z() = rate;
    return motion;
  });
  imu::ImuOptions options;
  imu::ImuDriver driver(options);
  testing::Bench<imu::ImuDriver> bench(driver, sensor, options.baud);
  bench.run(6.0);
  EXPECT_TRUE(driver.alive());
  EXPECT_EQ(sensor.rate_hz(), 20);
  EXPECT_NEAR(rad_to_deg(driver.bias_rad_per_s().z()), sensor.bias_deg_per_s(), 0.05);
  driver.take_samples();
  rate = 0.5;
  bench.run(2.0);
  const auto samples = driver.take_samples();
  EXPECT_NEAR(static_cast<double>(samples.size()), 40.0, 2.0);
  double angle = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    angle += samples[i].angular_velocity_rad_per_s.z() *
             (samples[i].utime - samples[i - 1].utime).seconds();
  }
  EXPECT_NEAR(angle, 0.5 * (samples.back().utime - samples.front().utime).seconds(), 0.01);
  EXPECT_NEAR(samples.back().acceleration_m_per_s2.z(), 9.81, 0.1);
}

TEST(ImuDriver, SaysWhenNothingComesAndAcceptsItsReturn) {
  imu::ImuEmulator sensor([](Utime) { return imu::Motion{}; });
  imu::ImuOptions options;
  imu::ImuDriver driver(options);
  testing::Bench<imu::ImuDriver> bench(driver, sensor, options.baud);
  bench.run(1.0);
  EXPECT_TRUE(driver.alive());
  bench.plug(false);
  bench.run(2.0);
  bench.plug(true);
  bench.run(1.0);
  EXPECT_TRUE(driver.alive());
  bench.spoil = [](std::vector<uint8_t>& bytes) { bytes.clear(); };
  bench.run(2.0);
  EXPECT_FALSE(driver.alive());
}

}  // namespace
}  // namespace marco::drivers
