#include "lcmtypes/convert.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>

#include "lcmtypes/channels.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/temporary_folder.hpp"

namespace marco {
namespace {

using ::marco::testing::IsNear;

template <class T>
T through_bytes(const T& value) {
  const EncodedMessage message = encode_sample(value);
  return std::get<T>(*decode_sample(message.channel, message.bytes));
}

TEST(Convert, ARegularScanKeepsItsBeams) {
  LaserScan scan;
  scan.utime = Utime::from_us(123456789);
  scan.channel = "LIDAR_REAR";
  scan.ranges_m = {1.0F, 0.0F, std::numeric_limits<float>::infinity(), 3.5F};
  scan.first_bearing_rad = -1.5;
  scan.bearing_step_rad = 0.25;
  const LaserScan back = through_bytes(scan);
  EXPECT_EQ(back.utime, scan.utime);
  EXPECT_EQ(back.channel, scan.channel);
  EXPECT_EQ(back.ranges_m, scan.ranges_m);
  EXPECT_DOUBLE_EQ(back.bearing_rad(3), -0.75);
}

TEST(Convert, AnIrregularScanKeepsBearingsAndTimes) {
  LaserScan scan;
  scan.utime = Utime::from_us(1000);
  scan.channel = channels::kLidarRaw;
  scan.ranges_m = {1.0F, 2.0F};
  scan.bearings_rad = {0.5F, -0.25F};
  scan.time_offsets_s = {0.0F, 0.125F};
  const LaserScan back = through_bytes(scan);
  EXPECT_EQ(back.bearings_rad, scan.bearings_rad);
  EXPECT_EQ(back.time_offsets_s, scan.time_offsets_s);
}

TEST(Convert, SensorInfoKeepsItsPose) {
  SensorInfo info;
  info.mount = SensorInfo::Mount::pantilt;
  info.parent_from_sensor = make_pose3({0.1, -0.2, 0.3}, 0.1, 0.2, 0.3);
  info.scan_duration_s = 0.02667;
  info.range_max_m = 32.0;
  const SensorInfo back = through_bytes(info);
  EXPECT_EQ(back.mount, info.mount);
  EXPECT_TRUE(back.parent_from_sensor.isApprox(info.parent_from_sensor, 1e-12));
  EXPECT_EQ(back.scan_duration_s, info.scan_duration_s);
  EXPECT_EQ(back.range_max_m, info.range_max_m);
}

TEST(Convert, RefusesAMessageThatContradictsItself) {
  sensor_info_t info = to_message(SensorInfo{});
  info.parent_from_sensor_quat[0] = 0.5;
  EXPECT_THROW(from_message(info), std::invalid_argument);
  info = to_message(SensorInfo{});
  info.range_max_m = -1.0;
  EXPECT_THROW(from_message(info), std::invalid_argument);
  odometry_t odometry = to_message(OdometrySample{});
  odometry.x_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(from_message(odometry), std::invalid_argument);
  grid_map_t grid{};
  grid.width_cells = 3;
  EXPECT_THROW(from_message(grid), std::invalid_argument);
}

TEST(Convert, RefusesMountsBeyondAnyRobot) {
  const auto said = [](const std::function<void(sensor_info_t&)>& spoil) {
    sensor_info_t info = to_message(SensorInfo{});
    spoil(info);
    return testing::complaint([&] { from_message(info); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(said([](sensor_info_t& info) { info.parent_from_sensor_m[1] = -19.0; }), "");
  for (const double far : {21.0, 1e4, 1e300, nan}) {
    EXPECT_THAT(said([far](sensor_info_t& info) { info.parent_from_sensor_m[0] = far; }),
                ::testing::HasSubstr("more than 20 m from its robot"));
    EXPECT_THAT(said([far](sensor_info_t& info) { info.tilt_axis_m[2] = far; }),
                ::testing::HasSubstr("more than 20 m from its pan axis"));
  }
}

TEST(Convert, RefusesGridsThatNoMapIsMadeOf) {
  for (const double wrong : {0.0, -0.05, 1e-300, 1e300, std::nan("")}) {
    grid_map_t grid{};
    grid.resolution_m = wrong;
    EXPECT_THAT(testing::complaint([&] { from_message(grid); }),
                ::testing::HasSubstr("between 1 mm and 100 m"));
    grid.resolution_m = 0.05;
    grid.origin_x_m = wrong == 1e300 ? 1e300 : std::nan("");
    EXPECT_THAT(testing::complaint([&] { from_message(grid); }), ::testing::HasSubstr("1000 km"));
  }
}

TEST(Convert, AGridTravelsInTilesAndKeepsItsPlace) {
  GridMap map;
  map.origin_m = {-1.0, 2.0};
  map.width_cells = 300;
  map.height_cells = 257;
  map.occupancy.assign(300U * 257U, GridMap::kUnknown);
  map.occupancy[299] = 77;          // last of the first row
  map.occupancy[256U * 300U] = 33;  // first of the last row
  const std::vector<grid_map_t> tiles = to_messages(map, Utime::from_us(5), 9);
  ASSERT_EQ(tiles.size(), 4U);
  const GridMap right = from_message(tiles[1]);
  EXPECT_DOUBLE_EQ(right.origin_m.x(), -1.0 + 256 * 0.05);
  EXPECT_EQ(right.at(43, 0), 77);
  const GridMap top = from_message(tiles[2]);
  EXPECT_EQ(top.at(0, 0), 33);
  EXPECT_EQ(top.height_cells, 1);
}

TEST(Convert, UndecodableBytesAndForeignChannelsGiveNothing) {
  const std::vector<uint8_t> junk{1, 2, 3};
  EXPECT_FALSE(decode_sample("LIDAR", junk));
  EXPECT_FALSE(decode_sample("LCM_SELF_TEST", junk));
}

TEST(Convert, WallsComeBackWhole) {
  Wall wall;
  wall.id = 7;
  wall.start_m = {1.0, -2.0};
  wall.end_m = {3.5, 4.0};
  for (int k = 0; k < 16; ++k) wall.covariance(k / 4, k % 4) = 0.1 * k;
  wall.existence = 0.75;
  wall.times_seen = 12;
  wall.end_seen = true;
  const Walls back = from_message(to_message(Walls{Wall{}, wall}, Utime::from_us(5), 3));
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[1].id, 7);
  EXPECT_EQ(back[1].start_m, wall.start_m);
  EXPECT_EQ(back[1].end_m, wall.end_m);
  EXPECT_EQ(back[1].covariance, wall.covariance);
  EXPECT_EQ(back[1].existence, 0.75);
  EXPECT_EQ(back[1].times_seen, 12);
  EXPECT_FALSE(back[1].start_seen);
  EXPECT_TRUE(back[1].end_seen);
}

TEST(Convert, AWallThatIsNotFiniteIsRefused) {
  line_map_t message = to_message(Walls{Wall{}}, Utime::from_us(5), 3);
  message.ends_m[0][2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(from_message(message), std::invalid_argument);
}

}  // namespace
}  // namespace marco
