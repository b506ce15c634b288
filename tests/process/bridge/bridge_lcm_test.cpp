// marco-bridge between Marco and a robot of another LCM stack on a network of its own. The robot's
// program knows nothing of Marco: its types are written after those stacks' own, in lcmtypes/.
#include <gmock/gmock.h>

#include <lcm/lcm-cpp.hpp>
#include <map>
#include <memory>

#include "geometry_msgs/PoseStamped.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "mbot_lcm_msgs/lidar_t.hpp"
#include "mbot_lcm_msgs/mbot_slam_reset_t.hpp"
#include "mbot_lcm_msgs/occupancy_grid_t.hpp"
#include "mbot_lcm_msgs/pose2D_t.hpp"
#include "nav_msgs/OccupancyGrid.hpp"
#include "nav_msgs/Odometry.hpp"
#include "nav_msgs/Path.hpp"
#include "sensor_msgs/LaserScan.hpp"
#include "tests/process/bridge/driven_room.hpp"
#include "tests/support/matchers.hpp"

namespace marco {
namespace {

using ::marco::testing::drive;
using ::marco::testing::DrivenRoom;
using ::marco::testing::IsNear;
using ::marco::testing::Program;
using ::marco::testing::TemporaryFolder;

// Two networks; isolated.sh gives them where it cannot give a network of its own.
std::string url_from(const char* variable, const char* otherwise) {
  const char* url = std::getenv(variable);
  return url == nullptr ? otherwise : url;
}
const std::string kTheirs = url_from("MARCO_SECOND_URL", "udpm://239.255.76.67:7667?ttl=0");
const std::string kOurs = url_from("LCM_DEFAULT_URL", "udpm://239.255.76.67:7668?ttl=0");
constexpr int kBeams = 240;
constexpr double kTurn = 2.0 * std::numbers::pi, kScanS = 0.1;
constexpr int64_t kStartUs = 1'700'000'000'000'000;

int64_t us(double time_s) { return kStartUs + static_cast<int64_t>(std::llround(1e6 * time_s)); }

/// What comes back, the newest on each channel.
template <class Message>
class Heard {
 public:
  Heard(lcm::LCM& lcm, const std::string& channel) { lcm.subscribe(channel, &Heard::take, this); }
  const Message& last() const { return last_; }
  int count() const { return count_; }

 private:
  void take(const lcm::ReceiveBuffer*, const std::string&, const Message* message) {
    last_ = *message;
    ++count_;
  }
  Message last_ = {};
  int count_ = 0;
};

class BridgeLcm : public ::testing::Test {
 protected:
  BridgeLcm()
      : theirs_(kTheirs),
        slam_("marco-slam", {"--lcm-url", kOurs}, (folder_.path() / "slam").string()),
        bridge_("marco-bridge", {"--lcm-url", kOurs, kTheirs}, (folder_.path() / "out").string()) {}

  void listen() {
    while (theirs_.handleTimeout(1) > 0) {
    }
  }
  std::string outputs() const {
    return files::read_whole_file((folder_.path() / "out").string()) +
           files::read_whole_file((folder_.path() / "slam").string());
  }

  DrivenRoom room_;
  TemporaryFolder folder_;
  lcm::LCM theirs_;
  Program slam_, bridge_;
};

class BridgeToMBot : public BridgeLcm {
 protected:
  // As the driver of 2023 fills it.
  mbot_lcm_msgs::lidar_t scan(double begin_s) const {
    mbot_lcm_msgs::lidar_t message;
    message.utime = us(begin_s + kScanS);
    message.num_ranges = kBeams;
    for (int i = 0; i < kBeams; ++i) {
      const int measured = kBeams - 1 - i;
      const double angle = kTurn * (measured + 0.5) / kBeams;
      const double time_s = begin_s + kScanS * measured / kBeams;
      message.ranges.push_back(static_cast<float>(room_.range_m(time_s, -angle)));
      message.thetas.push_back(static_cast<float>(kTurn - angle));
      message.times.push_back(us(begin_s + kScanS * i / kBeams));
      message.intensities.push_back(0.0F);
    }
    return message;
  }
  void send(double time_s) {
    for (const double at_s : {time_s, time_s + 0.5 * kScanS, time_s + kScanS}) {
      const Pose2 pose = room_.pose_at(at_s);
      mbot_lcm_msgs::pose2D_t odometry;
      odometry.utime = us(at_s);
      odometry.x = static_cast<float>(pose.x_m);
      odometry.y = static_cast<float>(pose.y_m);
      odometry.theta = static_cast<float>(pose.theta_rad);
      theirs_.publish("MBOT_ODOMETRY", &odometry);
    }
    const auto message = scan(time_s);
    theirs_.publish("LIDAR", &message);
    listen();
  }
};

TEST_F(BridgeToMBot, GivesPoseAndMapBackAndBeginsAgainWhenAsked) {
  ASSERT_EQ(mbot_lcm_msgs::lidar_t::getHash(), 0x89dc5b879a5056cf);
  ASSERT_EQ(mbot_lcm_msgs::pose2D_t::getHash(), 0x1f317af1246276ac);
  ASSERT_EQ(static_cast<uint64_t>(mbot_lcm_msgs::occupancy_grid_t::getHash()), 0xd5447e494a66cc92);
  ASSERT_EQ(mbot_lcm_msgs::mbot_slam_reset_t::getHash(), 0x41b599f392e6d5c1);
  Heard<mbot_lcm_msgs::pose2D_t> pose(theirs_, "SLAM_POSE");
  Heard<mbot_lcm_msgs::occupancy_grid_t> map(theirs_, "SLAM_MAP");
  double end_s = 0.0;
  EXPECT_TRUE(drive(40.0, [&](double time_s) {
    send(end_s = time_s);
    if (pose.count() > 0) room_.start(time_s + 0.2);
    return time_s > room_.starts_s() + 8.0 && map.count() > 1 &&
           pose.last().utime > us(time_s - 0.5);
  })) << outputs();
  const double at_s = 1e-6 * static_cast<double>(pose.last().utime - kStartUs);
  const Pose2 estimate{pose.last().x, pose.last().y, pose.last().theta};
  EXPECT_THAT(estimate, IsNear(room_.pose_at(at_s), 0.05, 0.03));
  const auto& grid = map.last();
  const auto cell = [&grid](double x, double y) {
    const auto column = static_cast<int>((x - static_cast<double>(grid.origin_x)) /
                                         static_cast<double>(grid.meters_per_cell));
    const auto row = static_cast<int>((y - static_cast<double>(grid.origin_y)) /
                                      static_cast<double>(grid.meters_per_cell));
    return static_cast<int>(grid.cells.at(static_cast<std::size_t>(row * grid.width + column)));
  };
  EXPECT_LT(cell(1.0, 0.0), -60);
  EXPECT_GT(std::max({cell(3.96, 0.3), cell(4.01, 0.3), cell(4.06, 0.3)}), 30);

  mbot_lcm_msgs::mbot_slam_reset_t reset;
  reset.slam_mode = 3;
  reset.retain_pose = 0;
  const auto begins_again = [&](double most_s) {
    theirs_.publish("MBOT_SYSTEM_RESET", &reset);
    const double begun_s = end_s;
    return drive(most_s, [&](double time_s) {
      send(end_s = begun_s + time_s);
      return time_s > 1.0 && std::hypot(pose.last().x, pose.last().y) < 0.6F;
    });
  };
  reset.utime = us(end_s) - 86'400'000'000;  // of yesterday's recording
  EXPECT_FALSE(begins_again(2.0));
  reset.utime = us(end_s);
  EXPECT_TRUE(begins_again(4.0)) << outputs();
}

class BridgeToDimos : public BridgeLcm {
 protected:
  static std_msgs::Header header(double time_s) {
    std_msgs::Header header;
    header.seq = 0;
    header.stamp.sec = static_cast<int32_t>(us(time_s) / 1'000'000);
    header.stamp.nsec = static_cast<int32_t>(us(time_s) % 1'000'000 * 1000);
    header.frame_id = "base_link";
    return header;
  }
  static double seconds_of(const std_msgs::Header& header) {
    return 1e-6 * static_cast<double>(int64_t{header.stamp.sec} * 1'000'000 +
                                      header.stamp.nsec / 1000 - kStartUs);
  }
  void send(double time_s) {
    const Pose2 pose = room_.pose_at(time_s);
    nav_msgs::Odometry odometry = {};
    odometry.header = header(time_s);
    odometry.pose.pose.position.x = pose.x_m;
    odometry.pose.pose.position.y = pose.y_m;
    odometry.pose.pose.orientation.z = std::sin(0.5 * pose.theta_rad);
    odometry.pose.pose.orientation.w = std::cos(0.5 * pose.theta_rad);
    theirs_.publish("/odom#nav_msgs.Odometry", &odometry);
    sensor_msgs::LaserScan scan = {};
    scan.header = header(time_s);
    scan.angle_min = static_cast<float>(-0.5 * kTurn);
    scan.angle_increment = static_cast<float>(kTurn / kBeams);
    scan.range_min = 0.1F;
    scan.range_max = 20.0F;
    scan.ranges_length = kBeams;
    for (int i = 0; i < kBeams; ++i) {
      const double bearing = -0.5 * kTurn + kTurn * i / kBeams;
      scan.ranges.push_back(static_cast<float>(room_.range_m(time_s, bearing)));
    }
    theirs_.publish("/scan#sensor_msgs.LaserScan", &scan);
    listen();
  }
};

TEST_F(BridgeToDimos, GivesPoseMapAndPathBack) {
  ASSERT_EQ(static_cast<uint64_t>(sensor_msgs::LaserScan::getHash()), 0x8de5754e00f25f00);
  ASSERT_EQ(static_cast<uint64_t>(nav_msgs::Odometry::getHash()), 0x94e17f94648cf0e4);
  ASSERT_EQ(static_cast<uint64_t>(nav_msgs::OccupancyGrid::getHash()), 0xe7dfd179cdfc3b65);
  ASSERT_EQ(static_cast<uint64_t>(nav_msgs::Path::getHash()), 0xc3ae62acb35793e2);
  ASSERT_EQ(geometry_msgs::PoseStamped::getHash(), 0x6a82696458c279a0);
  Heard<geometry_msgs::PoseStamped> pose(theirs_, "/slam_pose#geometry_msgs.PoseStamped");
  Heard<nav_msgs::OccupancyGrid> map(theirs_, "/map#nav_msgs.OccupancyGrid");
  Heard<nav_msgs::Path> path(theirs_, "/marco/path#nav_msgs.Path");
  EXPECT_TRUE(drive(40.0, [&](double time_s) {
    send(time_s);
    if (pose.count() > 0) room_.start(time_s + 0.2);
    return time_s > room_.starts_s() + 8.0 && map.count() > 1 && path.count() > 0 &&
           seconds_of(pose.last().header) > time_s - 0.5;
  })) << outputs();
  const auto& q = pose.last().pose.orientation;
  const Pose2 estimate{pose.last().pose.position.x, pose.last().pose.position.y,
                       2.0 * std::atan2(q.z, q.w)};
  EXPECT_THAT(estimate, IsNear(room_.pose_at(seconds_of(pose.last().header)), 0.05, 0.03));
  const auto& grid = map.last();
  ASSERT_EQ(grid.data.size(), static_cast<std::size_t>(grid.info.width * grid.info.height));
  const auto column = static_cast<int>((1.0 - grid.info.origin.position.x) /
                                       static_cast<double>(grid.info.resolution));
  const auto row =
      static_cast<int>(-grid.info.origin.position.y / static_cast<double>(grid.info.resolution));
  EXPECT_LT(grid.data.at(static_cast<std::size_t>(row * grid.info.width + column)), 40);
  EXPECT_GT(path.last().poses_length, 0);
}

}  // namespace
}  // namespace marco
