// Other people's recordings: what is found in each without a flag.
#include <gmock/gmock.h>

#include <string>

#include "recordings/recording.hpp"
#include "tests/support/real_data.hpp"
#include "tests/support/recorded.hpp"

namespace marco {
namespace {

using ::marco::testing::read_all;
using ::marco::testing::Recorded;
using ::testing::Contains;
using ::testing::HasSubstr;

struct Known {
  const char* name;
  std::size_t scans, odometry, imu, pantilt;
  double x_m, yaw_deg;  // of the first laser
  const char* note;
};

TEST(RosRecordings, OfRobotsTellLaserPlaceAndOdometry) {
  const char* folder = marco::testing::real_data();
  if (folder == nullptr) GTEST_SKIP();
  const Known recordings[] = {
      {"guardian_3.bag", 1038, 2079, 0, 0, -0.432, 180, "/scan is ignored"},
      {"guardian_controller_2.bag", 1031, 2060, 0, 0, -0.432, 180, "odometry /guardian_node/odom"},
      {"ship_interior_with_tilting_laser.bag", 414, 1966, 0, 1010, -0.432, 180,
       "the joint from base_link to hokuyo_tilt_laser_link is its pan-tilt"},
      {"macfirst_floor_take_2", 357, 920, 0, 0, 0.004, 90,
       "odometry /odom: base_link in odom, 8.3"},
      {"macfirst_floor_take_2_mcap", 357, 920, 0, 0, 0.004, 90, "rplidar_link"},
      {"kitchen_1", 675, 0, 2912, 0, 0, 0, "degrees per second"},
  };
  for (const Known& known : recordings) {
    const auto reader = open_recording(std::string(folder) + "/rosbags/" + known.name);
    const Recorded recorded = read_all(*reader);
    EXPECT_EQ(recorded.scans.size(), known.scans) << known.name;
    EXPECT_EQ(recorded.odometry.size(), known.odometry) << known.name;
    EXPECT_EQ(recorded.imu.size(), known.imu) << known.name;
    EXPECT_EQ(recorded.pantilt.size(), known.pantilt) << known.name;
    EXPECT_TRUE(recorded.report.dropped.empty()) << known.name;
    EXPECT_THAT(recorded.report.notes, Contains(HasSubstr(known.note))) << known.name;
    for (const SensorInfo& info : recorded.infos) {
      if (info.channel != "LIDAR") continue;
      const Pose2 place = flatten(info.parent_from_sensor);
      EXPECT_NEAR(place.x_m, known.x_m, 1e-3) << known.name;
      EXPECT_NEAR(std::abs(rad_to_deg(place.theta_rad)), known.yaw_deg, 0.1) << known.name;
    }
  }
}

TEST(RosRecordings, WithoutALaserSayWhatIsInThem) {
  const char* folder = marco::testing::real_data();
  if (folder == nullptr) GTEST_SKIP();
  const std::pair<const char*, const char*> recordings[] = {
      {"basic.bag", "/input (std_msgs/String)"},
      {"cdr_test_db3", "test_msgs/Arrays"},
      {"cdr_test_mcap", "test_msgs/BasicTypes"},
      {"cm_moving_obstacle", "nav2_msgs/Costmap"},
      {"lambkin_basic", "/clock (rosgraph_msgs/Clock)"},
      {"talker_mcap", "/topic"},
  };
  for (const auto& [name, content] : recordings) {
    const std::string path = std::string(folder) + "/rosbags/" + name;
    EXPECT_THAT([&path] { open_recording(path); },
                ::testing::ThrowsMessage<std::invalid_argument>(
                    ::testing::AllOf(HasSubstr("no laser"), HasSubstr(content))))
        << name;
  }
}

}  // namespace
}  // namespace marco
