// Every value, field by field, against bytes that are written down by hand: a field that both
// directions confuse comes back whole from a round trip, but other programs would misread it.
#include <gtest/gtest.h>

#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "tests/support/wire.hpp"

namespace marco {
namespace {

using Bytes = std::vector<uint8_t>;
using testing::Wire;

// Both directions: what is encoded, and what is encoded again after decoding the same bytes.
void expect_sample(const Sample& sample, const std::string& channel, const Bytes& wire) {
  const EncodedMessage message = encode_sample(sample);
  EXPECT_EQ(message.channel, channel);
  EXPECT_EQ(message.bytes, wire);
  const auto back = decode_sample(channel, wire);
  ASSERT_TRUE(back);
  EXPECT_EQ(encode_sample(*back).bytes, wire);
  EXPECT_EQ(encode_sample(*back).utime, message.utime);
}

template <class Message, class Value>
void expect_message(const Value& value, const Bytes& wire) {
  EXPECT_EQ(encode_message(to_message(value)), wire);
  const auto message = decode_message<Message>(wire);
  ASSERT_TRUE(message);
  EXPECT_EQ(encode_message(to_message(from_message(*message))), wire);
}

TEST(WireFormat, PlanarLidarIsLibbots) {
  LaserScan scan;
  scan.utime = Utime::from_us(123456789);
  scan.channel = "LIDAR_REAR";
  scan.ranges_m = {1.0F, 0.0F, std::numeric_limits<float>::infinity(), 3.5F};
  scan.first_bearing_rad = -1.5;
  scan.bearing_step_rad = 0.25;
  expect_sample(scan, "LIDAR_REAR",
                Wire(static_cast<int64_t>(0xe3d17423180b5e8dU))(
                    int64_t{123456789}, 4, 1.0F, 0.0F, scan.ranges_m[2], 3.5F)(0, -1.5F, 0.25F)
                    .bytes());
}

TEST(WireFormat, LidarRawIsMbots) {
  LaserScan scan;
  scan.utime = Utime::from_us(1000);
  scan.channel = "LIDAR_RAW_TOP";
  scan.ranges_m = {1.0F, 2.0F};
  scan.bearings_rad = {0.5F, -0.25F};
  scan.time_offsets_s = {0.0F, 0.125F};
  expect_sample(scan, "LIDAR_RAW_TOP",
                Wire(static_cast<int64_t>(0x89dc5b879a5056cfU))(int64_t{1000}, 2, 1.0F, 2.0F)(
                    0.5F, -0.25F)(int64_t{1000}, int64_t{126000})(0.0F, 0.0F)
                    .bytes());
}

TEST(WireFormat, SensorInfo) {
  SensorInfo info;
  info.utime = Utime::from_us(7);
  info.channel = "CAMERA";
  info.mount = SensorInfo::Mount::pantilt;
  info.parent_from_sensor = make_pose3({0.1, -0.2, 0.3}, 0.0, 0.0, deg_to_rad(180.0));
  info.tilt_axis_m = {0.01, 0.02, 0.03};
  info.scan_duration_s = 0.02667;
  info.range_min_m = 0.25;
  info.range_max_m = 32.0;
  info.range_sigma_m = 0.015;
  info.focal_length_px = 640.0;
  Wire wire(sensor_info_t::getHash());
  wire(int64_t{7}).text("CAMERA")(int8_t{1}, 0.1, -0.2, 0.3);
  // Half a turn about z: w x y z.
  const Eigen::Quaterniond turn(info.parent_from_sensor.linear());
  EXPECT_NEAR(std::abs(turn.z()), 1.0, 1e-12);
  wire(turn.w(), turn.x(), turn.y(), turn.z())(0.01, 0.02, 0.03);
  wire(0.02667, 0.25, 32.0, 0.015, 640.0);
  EXPECT_EQ(encode_sample(info).bytes, wire.bytes());
  const auto back = decode_sample(channels::kSensorInfo, wire.bytes());
  ASSERT_TRUE(back);
  const auto& read = std::get<SensorInfo>(*back);
  EXPECT_TRUE(read.parent_from_sensor.isApprox(info.parent_from_sensor, 1e-12));
  SensorInfo same = read;  // the quaternion may differ in its last bit
  same.parent_from_sensor = info.parent_from_sensor;
  EXPECT_EQ(encode_sample(same).bytes, wire.bytes());
}

TEST(WireFormat, OdometryImuPanTiltStateAndTruePose) {
  OdometrySample odometry;
  odometry.utime = Utime::from_us(11);
  odometry.odom_from_robot = {1.5, -2.5, 0.75};
  odometry.velocity_m_per_s = 0.4;
  odometry.yaw_rate_rad_per_s = -0.3;
  odometry.left_clicks = -12;
  odometry.right_clicks = 34;
  expect_sample(odometry, "ODOMETRY",
                Wire(odometry_t::getHash())(int64_t{11}, 1.5, -2.5, 0.75, 0.4, -0.3, int64_t{-12},
                                            int64_t{34})
                    .bytes());
  ImuSample imu;
  imu.utime = Utime::from_us(12);
  imu.angular_velocity_rad_per_s = {0.1, 0.2, 0.3};
  imu.acceleration_m_per_s2 = {1.0, 2.0, 9.81};
  expect_sample(imu, "IMU",
                Wire(imu_t::getHash())(int64_t{12}, 0.1, 0.2, 0.3, 1.0, 2.0, 9.81).bytes());
  PanTiltState state;
  state.utime = Utime::from_us(13);
  state.pan_rad = 0.5;
  state.tilt_rad = -0.25;
  state.pan_rate_rad_per_s = 0.01;
  state.tilt_rate_rad_per_s = 0.02;
  expect_sample(state, "PANTILT_STATE",
                Wire(pantilt_state_t::getHash())(int64_t{13}, 0.5, -0.25, 0.01, 0.02).bytes());
  expect_sample(TruePose{Utime::from_us(14), {4.0, 5.0, -1.0}}, "TRUE_POSE",
                Wire(pose2_t::getHash())(int64_t{14}, 4.0, 5.0, -1.0).bytes());
  expect_sample(TruePose{Utime::from_us(14), {4.0, 5.0, -1.0}, true}, "TRUE_POSE_BY_ARRIVAL",
                Wire(pose2_t::getHash())(int64_t{14}, 4.0, 5.0, -1.0).bytes());
}

TEST(WireFormat, BaseCommand) {
  BaseCommand command;
  command.utime = Utime::from_us(21);
  command.id = 42;
  command.kind = BaseCommand::Kind::go_to;
  command.distance_m = 0.1;
  command.angle_rad = 0.2;
  command.velocity_m_per_s = 0.3;
  command.yaw_rate_rad_per_s = 0.4;
  command.point_m = {1.5, -2.5};
  command.max_velocity_m_per_s = 0.5;
  command.max_yaw_rate_rad_per_s = 0.6;
  command.acceleration_m_per_s2 = 0.7;
  Wire wire(base_command_t::getHash());
  wire(int64_t{21}, int64_t{42}, int8_t{4}, 0.1, 0.2, 0.3, 0.4, 1.5, -2.5, 0.5, 0.6, 0.7);
  expect_message<base_command_t>(command, wire.bytes());
}

TEST(WireFormat, BaseStatus) {
  BaseStatus status;
  status.utime = Utime::from_us(22);
  status.base = "p2os";
  status.link = BaseStatus::Link::up;
  status.command_id = 43;
  status.command = BaseStatus::Command::shortened;
  status.motors_on = true;
  status.battery_v = {12.5, 25.0};
  status.bumpers = {true, false, true};
  status.note = "wall";
  Wire wire(base_status_t::getHash());
  wire(int64_t{22}).text("p2os")(int8_t{2}, int64_t{43}, int8_t{3}, int8_t{1}, 2, 12.5, 25.0);
  wire(3, int8_t{1}, int8_t{0}, int8_t{1}).text("wall");
  expect_message<base_status_t>(status, wire.bytes());
}

TEST(WireFormat, EmergencyStopSonarPanTiltCommandAndGamepad) {
  Wire stop(emergency_stop_t::getHash());
  stop(int64_t{23}, int8_t{1}).text("marco stop").text("a child");
  expect_message<emergency_stop_t>(EmergencyStop{Utime::from_us(23), true, "marco stop", "a child"},
                                   stop.bytes());
  SonarRing ring;
  ring.utime = Utime::from_us(24);
  ring.readings = {{1.25, {0.1, 0.2, 0.3}}, {0.0, {-0.1, 0.4, 3.0}}};
  ring.cone_rad = 0.5;
  Wire sonar(sonar_t::getHash());
  sonar(int64_t{24}, 2, 1.25, 0.0)(0.1, -0.1)(0.2, 0.4)(0.3, 3.0)(0.5);
  expect_message<sonar_t>(ring, sonar.bytes());
  PanTiltCommand look;
  look.utime = Utime::from_us(25);
  look.kind = PanTiltCommand::Kind::go_to;
  look.pan_rad = 0.5;
  look.tilt_rad = -0.25;
  look.pan_rate_rad_per_s = 0.1;
  look.tilt_rate_rad_per_s = 0.2;
  Wire command(pantilt_command_t::getHash());
  command(int64_t{25}, int8_t{1}, 0.5, -0.25, 0.1, 0.2);
  expect_message<pantilt_command_t>(look, command.bytes());
  Wire gamepad(gamepad_t::getHash());
  gamepad(int64_t{26}, int8_t{1}, 2, 0.5F, -1.0F)(3, int8_t{0}, int8_t{1}, int8_t{1});
  expect_message<gamepad_t>(
      GamepadState{Utime::from_us(26), true, {0.5F, -1.0F}, {false, true, true}}, gamepad.bytes());
}

TEST(WireFormat, TrajectoryAndWalls) {
  const Trajectory path = {{Utime::from_us(31), {1.0, 2.0, 0.5}},
                           {Utime::from_us(32), {3.0, 4.0, -0.5}}};
  Wire trajectory(trajectory_t::getHash());
  trajectory(int64_t{33}, int64_t{9}, 2, int64_t{31}, int64_t{32});
  trajectory(1.0, 3.0)(2.0, 4.0)(0.5, -0.5);
  EXPECT_EQ(encode_message(to_message(path, Utime::from_us(33), 9)), trajectory.bytes());
  const Trajectory path_back = from_message(*decode_message<trajectory_t>(trajectory.bytes()));
  EXPECT_EQ(encode_message(to_message(path_back, Utime::from_us(33), 9)), trajectory.bytes());

  Wall wall;
  wall.id = 7;
  wall.start_m = {1.0, -2.0};
  wall.end_m = {3.5, 4.0};
  for (int k = 0; k < 16; ++k) wall.covariance(k / 4, k % 4) = 0.1 * k;
  wall.existence = 0.75;
  wall.times_seen = 12;
  wall.end_seen = true;
  Wire walls(line_map_t::getHash());
  walls(int64_t{33}, int64_t{9}, 1, int64_t{7}, 1.0, -2.0, 3.5, 4.0);
  for (int k = 0; k < 16; ++k) walls(0.1 * k);  // row by row
  walls(0.75, int64_t{12}, int8_t{0}, int8_t{1});
  EXPECT_EQ(encode_message(to_message(Walls{wall}, Utime::from_us(33), 9)), walls.bytes());
  const Walls back = from_message(*decode_message<line_map_t>(walls.bytes()));
  EXPECT_EQ(encode_message(to_message(back, Utime::from_us(33), 9)), walls.bytes());
}

TEST(WireFormat, LoopClosures) {
  const LoopClosures loops = {
      {Utime::from_us(31), Utime::from_us(35), {1.0, -2.0}, {3.5, 4.0}, 0.25, 0.125, 0.75}};
  Wire wire(loop_closures_t::getHash());
  wire(int64_t{36}, int64_t{9}, 1, int64_t{31}, int64_t{35});
  wire(1.0, -2.0, 3.5, 4.0)(0.25, 0.125, 0.75);
  EXPECT_EQ(encode_message(to_message(loops, Utime::from_us(36), 9)), wire.bytes());
  const LoopClosures back = from_message(*decode_message<loop_closures_t>(wire.bytes()));
  EXPECT_EQ(encode_message(to_message(back, Utime::from_us(36), 9)), wire.bytes());
}

TEST(WireFormat, GridMap) {
  GridMap map;
  map.origin_m = {-1.0, 2.0};
  map.resolution_m = 0.1;
  map.width_cells = 2;
  map.height_cells = 3;
  map.occupancy = {1, 2, 3, 4, 5, GridMap::kUnknown};
  Wire wire(grid_map_t::getHash());
  wire(int64_t{34}, int64_t{9}, -1.0, 2.0, 0.1, 2, 3, 6);
  for (const uint8_t cell : map.occupancy) wire(cell);
  const std::vector<grid_map_t> tiles = to_messages(map, Utime::from_us(34), 9);
  ASSERT_EQ(tiles.size(), 1U);
  EXPECT_EQ(encode_message(tiles[0]), wire.bytes());
  const GridMap back = from_message(*decode_message<grid_map_t>(wire.bytes()));
  EXPECT_EQ(encode_message(to_messages(back, Utime::from_us(34), 9).at(0)), wire.bytes());
}

}  // namespace
}  // namespace marco
