// Bytes that are no message must be refused by every decoder, never read or written out of bounds:
// run under the sanitizers these tests are the judge.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "bot_core/image_t.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/grid_map_t.hpp"
#include "marco/lidar_raw_t.hpp"
#include "marco/mesh_t.hpp"
#include "marco/process_status_t.hpp"
#include "marco/scene_t.hpp"
#include "marco/trajectory_t.hpp"

namespace marco {
namespace {

template <class Message>
int decode(const std::vector<uint8_t>& bytes) {
  Message message{};
  return message.decode(bytes.data(), 0, static_cast<int>(bytes.size()));
}

// Spoils a message many times. Bytes are refused, or they are one message: what was decoded takes
// exactly the bytes that were consumed. Both must happen, or nothing would be tested.
template <class Message>
void torture(const Message& message, unsigned seed) {
  std::mt19937 random(seed);
  const std::vector<uint8_t> whole = encode_message(message);
  EXPECT_EQ(decode<Message>(whole), static_cast<int>(whole.size()));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_LT(decode<Message>({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}),
              0)
        << "cut to " << size << " of " << whole.size();
  }
  int refused = 0, decoded = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<uint8_t> bytes = whole;
    const int flips = std::uniform_int_distribution<int>(1, 6)(random);
    for (int i = 0; i < flips; ++i) {
      // Mostly where the lengths are: the head, behind the fingerprint.
      const std::size_t reach =
          round % 2 == 0 ? std::min<std::size_t>(bytes.size(), 80) : bytes.size();
      bytes[8 + random() % (reach - 8)] = static_cast<uint8_t>(random());
    }
    if (round % 5 == 0) bytes.resize(8 + random() % (bytes.size() - 7));
    Message spoilt{};
    const int consumed = spoilt.decode(bytes.data(), 0, static_cast<int>(bytes.size()));
    if (consumed < 0) {
      ++refused;
      continue;
    }
    ++decoded;
    ASSERT_LE(consumed, static_cast<int>(bytes.size()));
    EXPECT_EQ(spoilt.getEncodedSize(), consumed);
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(decoded, 100);
}

TEST(HostileBytes, PlanarLidar) {
  bot_core::planar_lidar_t message{};
  message.nranges = 5;
  message.ranges.assign(5, 1.0F);
  message.nintensities = 2;
  message.intensities.assign(2, 1.0F);
  torture(message, 1);
}

TEST(HostileBytes, Image) {
  bot_core::image_t message{};
  message.size = 3;
  message.data.assign(3, 7);
  message.nmetadata = 1;
  message.metadata.resize(1);
  message.metadata[0].key = "key";
  message.metadata[0].n = 2;
  message.metadata[0].value.assign(2, 1);
  torture(message, 2);
}

TEST(HostileBytes, LidarRawTrajectoryAndGrid) {
  lidar_raw_t raw{};
  raw.num_ranges = 2;
  raw.ranges = raw.thetas = raw.intensities = {1.0F, 2.0F};
  raw.times = {1, 2};
  torture(raw, 3);
  trajectory_t trajectory{};
  trajectory.num_poses = 1;
  trajectory.utimes = {1};
  trajectory.x_m = trajectory.y_m = trajectory.theta_rad = {0.5};
  torture(trajectory, 4);
  GridMap map;
  map.width_cells = map.height_cells = 3;
  map.occupancy.assign(9, 50);
  torture(to_messages(map, Utime::from_us(1), 1).at(0), 5);
}

TEST(HostileBytes, SceneMeshAndStatus) {
  scene_t scene{};
  scene.rows = 1;
  scene.columns = 2;
  scene.ranges_m = {{1.0F, 2.0F}};
  scene.world_from_sensor_m = {{0, 0, 0}};
  scene.world_from_sensor_quat = {{1, 0, 0, 0}};
  torture(scene, 6);
  mesh_t mesh{};
  mesh.num_vertices = 1;
  mesh.vertices_m = mesh.normals = {{0, 0, 1}};
  mesh.num_triangles = 1;
  mesh.triangles = {{0, 0, 0}};
  torture(mesh, 7);
  process_status_t status{};
  status.process = "marco-slam";
  status.state = "well";
  status.num_causes = 1;
  status.drop_causes = {"undecodable"};
  status.drop_counts = {3};
  torture(status, 8);
}

TEST(HostileBytes, ANegativeAndAHugeLengthAreRefused) {
  bot_core::planar_lidar_t message{};
  message.nranges = 1;
  message.ranges = {1.0F};
  std::vector<uint8_t> bytes = encode_message(message);
  for (const uint8_t top : std::vector<uint8_t>{0x80, 0xff, 0x7f, 0x40}) {
    bytes[16] = top;  // behind fingerprint and utime: nranges, big endian
    EXPECT_LT(decode<bot_core::planar_lidar_t>(bytes), 0);
  }
}

TEST(HostileBytes, AStampFarFromAnyRealTimeIsRefused) {
  for (const int64_t utime : {std::numeric_limits<int64_t>::min(), int64_t{1} << 61,
                              std::numeric_limits<int64_t>::max()}) {
    odometry_t odometry{};
    odometry.utime = utime;
    EXPECT_THROW(from_message(odometry), std::invalid_argument);
    lidar_raw_t raw{};
    raw.num_ranges = 1;
    raw.ranges = raw.thetas = raw.intensities = {1.0F};
    raw.times = {utime};
    EXPECT_THROW(from_message(raw, "LIDAR_RAW"), std::invalid_argument);
  }
  odometry_t today{};
  today.utime = 1'700'000'000'000'000;
  EXPECT_EQ(from_message(today).utime, Utime::from_us(1'700'000'000'000'000));
}

}  // namespace
}  // namespace marco
