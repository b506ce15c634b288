#include <gmock/gmock.h>

#include "simulator/devices/p2os/emulator.hpp"

namespace marco::drivers::p2os {
namespace {

/// A host that has shaken hands and keeps all the packets it gets.
struct Host {
  explicit Host(P2osWorld world = {}) : robot(std::move(world)) {
    robot.on_connection(true, now);
    for (const CommandId id : {CommandId::pulse, CommandId::open, CommandId::close})
      say({id, std::nullopt, ""});
    say({CommandId::open, 1, ""});
  }
  void say(const Command& command, int baud = kBaud) {
    robot.receive(encode_command(command), baud, now);
    run(0.05);
  }
  void run(double seconds) {
    const Utime end = now + Duration::from_seconds(seconds);
    while (now < end) {
      now = now + Duration::from_us(1000);
      Bytes out;
      robot.advance(now, out);
      parser.push(out);
      while (const auto payload = parser.next()) packets.push_back(*payload);
    }
  }
  /// The last packet of this kind, and how many there were.
  Bytes last(uint8_t id) const {
    for (auto packet = packets.rbegin(); packet != packets.rend(); ++packet) {
      if (packet->at(0) == id) return *packet;
    }
    return {};
  }
  long count(uint8_t id) const {
    return std::count_if(packets.begin(), packets.end(),
                         [id](const Bytes& packet) { return packet[0] == id; });
  }
  void visca(std::initializer_list<int> bytes) {
    std::string text;
    for (const int byte : bytes) text += static_cast<char>(byte);
    say({CommandId::tty2, std::nullopt, text});
  }

  P2osEmulator robot;
  Utime now = Utime::from_us(1'000'000'000);
  PacketParser parser;
  std::vector<Bytes> packets;
};

// A program that never says SONAR 1 hears them: real robots' are on after OPEN.
TEST(P2osAnswers, SonarsAreOnAfterOpen) {
  P2osWorld world;
  world.sonar_range_m = [](const Pose2&) { return 1.5; };
  Host host(world);
  host.run(0.5);
  const auto heard = decode_sip(host.last(0x32));
  ASSERT_TRUE(heard.has_value());
  EXPECT_EQ(heard->flags & 0x1E, 0x1E);
  ASSERT_FALSE(heard->sonars.empty());
  EXPECT_NEAR(heard->sonars[0].range * model_of("p2dx")->mm_per_range, 1500.0, 0.3);
  host.say({CommandId::sonar, 0, ""});
  host.run(0.3);
  EXPECT_TRUE(decode_sip(host.last(0x32))->sonars.empty());
}

TEST(P2osAnswers, TellsItsSettings) {
  Host host;
  host.say({CommandId::set_max_velocity, 700, ""});
  host.say({CommandId::set_acceleration, 250, ""});
  host.say({CommandId::set_acceleration, -400, ""});
  host.say({CommandId::config, 1, ""});
  host.run(0.3);  // 140 bytes take 0.15 s
  const auto config = decode_config(host.last(kConfigPacket));
  ASSERT_TRUE(config.has_value());
  EXPECT_EQ(config->name, (RobotName{"MARCO", "Pioneer", "P2DX"}));
  EXPECT_EQ(config->velocity_top, 2200);
  EXPECT_EQ(config->velocity_max, 700);
  EXPECT_EQ(config->acceleration, 250);
  EXPECT_EQ(config->deceleration, 400);
  EXPECT_EQ(config->watchdog_ms, 2000);
  EXPECT_EQ(config->front_bumpers, 5);
  // Where ARIA looks: behind three texts and a byte, the top rotation and the top velocity.
  const Bytes packet = host.last(kConfigPacket);
  const std::size_t at = 1 + sizeof("Pioneer") + sizeof("P2DX") + sizeof("MARCO-0001") + 1;
  EXPECT_EQ(packet[at] | packet[at + 1] << 8, 500);
  EXPECT_EQ(packet[at + 2] | packet[at + 3] << 8, 2200);
}

TEST(P2osAnswers, CutPacketsAreNone) {
  Bytes packet = encode_config({});
  const Bytes payload(packet.begin() + 3, packet.end() - 2);
  for (std::size_t size = 0; size < payload.size(); ++size) {
    EXPECT_FALSE(decode_config(std::span(payload).first(size)).has_value()) << size;
  }
  EXPECT_EQ(decode_config(payload), RobotConfig{});
}

TEST(P2osAnswers, EncodersCountWhatTheWheelsRolled) {
  Host host;
  host.say({CommandId::encoder, 2, ""});
  host.say({CommandId::enable, 1, ""});
  host.say({CommandId::move, 500, ""});
  host.run(1.0);
  EXPECT_GE(host.count(kEncoderPacket), 9);  // one with each information packet
  host.say({CommandId::pulse, std::nullopt, ""});
  host.run(1.5);
  host.say({CommandId::pulse, std::nullopt, ""});
  host.run(1.0);
  const auto ticks = decode_encoders(host.last(kEncoderPacket));
  ASSERT_TRUE(ticks.has_value());
  EXPECT_NEAR(ticks->left, 500 * 39, 39);
  EXPECT_EQ(ticks->left, ticks->right);
  host.say({CommandId::encoder, 0, ""});
  host.run(0.2);
  const long before = host.count(kEncoderPacket);
  host.run(0.5);
  EXPECT_EQ(host.count(kEncoderPacket), before);
}

TEST(P2osAnswers, PortsGripperAndSpeedOfTheLine) {
  P2osWorld world;
  world.touch = [] { return Touch{0x04, 0x01, false}; };
  Host host(world);
  host.say({CommandId::digital_out, 0x0F05, ""});
  host.say({CommandId::io_request, 1, ""});
  host.run(0.1);
  const auto ports = decode_io(host.last(kIoPacket));
  ASSERT_TRUE(ports.has_value());
  EXPECT_EQ(ports->digital_in[0], 0xFB);
  EXPECT_EQ(ports->digital_out[0], 0x05);
  EXPECT_EQ(ports->analog.size(), 9U);
  host.say({CommandId::gripper_request, 1, ""});
  host.run(0.1);
  EXPECT_EQ(host.last(kGripperPacket).at(1), 0);  // none
  host.say({CommandId::host_baud, 2, ""});
  host.run(0.2);
  const long heard = host.count(kConfigPacket);
  host.say({CommandId::config, 1, ""}, 9600);
  host.run(0.2);
  EXPECT_EQ(host.count(kConfigPacket), heard);
  host.say({CommandId::config, 1, ""}, 38'400);
  host.run(0.2);
  EXPECT_EQ(decode_config(host.last(kConfigPacket)).value().host_baud, 2);
  host.say({CommandId::close, std::nullopt, ""}, 38'400);
  host.run(0.2);
  host.say({CommandId::pulse, std::nullopt, ""}, 9600);  // SYNC0, at the first speed again
  EXPECT_EQ(host.packets.back(), Bytes{0});
}

TEST(P2osAnswers, TheCameraHeadHearsWhatIsPassedOn) {
  Host host;
  // Pan to 430 units (half its way to the right), tilt to +140, at top speed.
  host.visca({0x81, 0x01, 0x06, 0x02, 0x18, 0x14, 0, 1, 0xA, 0xE, 0, 0, 8, 0xC, 0xFF});
  EXPECT_TRUE(host.robot.camera_head().moving());
  host.run(1.0);  // 47.5 deg at 80 deg/s
  EXPECT_NEAR(rad_to_deg(host.robot.camera_head().pan_rad()), -47.5, 0.1);
  EXPECT_NEAR(rad_to_deg(host.robot.camera_head().tilt_rad()), 140 / 14.05, 0.1);
  host.say({CommandId::get_aux, 0, ""});  // away with the acknowledgement and the completion
  host.visca({0x81, 0x09, 0x06, 0x12, 0xFF});
  host.say({CommandId::get_aux, 11, ""});
  host.run(0.2);
  EXPECT_EQ(host.last(kAuxPacket), (Bytes{0xB0, 0x90, 0x50, 0, 1, 0xA, 0xE, 0, 0, 8, 0xC, 0xFF}));
  host.visca({0x81, 0x01, 0x06, 0x02, 0x18, 0x14, 0, 7, 0xF, 0xF, 0, 0, 0, 0, 0xFF});
  host.run(2.0);
  EXPECT_NEAR(rad_to_deg(host.robot.camera_head().pan_rad()), -95.0, 0.1);  // its end
  host.visca({0x81, 0x01, 0x06, 0x04, 0xFF});
  host.run(2.0);
  EXPECT_EQ(host.robot.camera_head().pan_rad(), 0.0);
}

}  // namespace
}  // namespace marco::drivers::p2os
