#include "lcmtypes/convert.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>

#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco {
namespace {

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

TEST(Convert, ASlamPoseSaysWhatItsMessageSays) {
  PoseEstimate estimate;
  estimate.utime = Utime::from_us(17);
  estimate.world_from_robot = {1.5, -2.5, 0.25};
  estimate.covariance << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  estimate.status = PoseEstimate::Status::predicted;
  estimate.overlap = 0.75;
  const slam_pose_t message = to_message(estimate);
  EXPECT_EQ(message.utime, 17);
  EXPECT_EQ(message.x_m, 1.5);
  EXPECT_EQ(message.y_m, -2.5);
  EXPECT_EQ(message.theta_rad, 0.25);
  EXPECT_EQ(message.covariance[0][2], 3.0);
  EXPECT_EQ(message.covariance[2][0], 7.0);
  EXPECT_EQ(message.status, 1);
  EXPECT_EQ(message.overlap, 0.75);
  EXPECT_EQ(from_message(message).covariance, estimate.covariance);
  EXPECT_EQ(from_message(message).status, PoseEstimate::Status::predicted);
  slam_pose_t unknown = message;
  unknown.status = 3;
  EXPECT_THROW(from_message(unknown), std::invalid_argument);
  unknown = message;
  unknown.y_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(from_message(unknown), std::invalid_argument);
}

TEST(Convert, UndecodableBytesAndForeignChannelsGiveNothing) {
  const std::vector<uint8_t> junk{1, 2, 3};
  EXPECT_FALSE(decode_sample("LIDAR", junk));
  EXPECT_FALSE(decode_sample("LCM_SELF_TEST", junk));
}

TEST(Convert, AWallThatIsNotFiniteIsRefused) {
  line_map_t message = to_message(Walls{Wall{}}, Utime::from_us(5), 3);
  message.ends_m[0][2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(from_message(message), std::invalid_argument);
}

TEST(Convert, ALoopClosureThatIsNotFiniteIsRefused) {
  const loop_closures_t sound = to_message(LoopClosures{LoopClosure{}}, Utime::from_us(5), 3);
  EXPECT_EQ(from_message(sound).size(), 1U);
  loop_closures_t message = sound;
  message.ends_m[0][2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(from_message(message), std::invalid_argument);
  message = sound;
  message.residual_m[0] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(from_message(message), std::invalid_argument);
}

}  // namespace
}  // namespace marco
