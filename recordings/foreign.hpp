#pragma once

#include <string>
#include <vector>

#include "lcm_tools/base/options.hpp"

namespace marco {

/// The meaning of a channel of another system, in a log or live.
struct ForeignChannel {
  std::string channel;      ///< POSIX extended regular expression, the whole name
  std::string fingerprint;  ///< of the message type, 16 hex digits
  std::string meaning;      ///< lidar, odometry, encoders, true_pose or ignore
  bool clockwise = false;   ///< lidar: bearings run clockwise
  /// lidar_t of MBot: its drivers count bearings in two senses; the stamp decides
  /// (settle_direction).
  bool direction_by_stamp = false;
  double range_min_m = 0.05;
  double range_max_m = 30.0;     ///< lidar: this range and more is no return
  double metres_per_tick = 0.0;  ///< encoders
  double track_m = 0.0;          ///< encoders: between the wheels

  template <class Visitor>
  void visit(Visitor& v) {
    v("channel", channel);
    v("fingerprint", fingerprint);
    v("meaning", meaning);
    v("clockwise", clockwise);
    v("direction_by_stamp", direction_by_stamp);
    v("range_min_m", range_min_m, kNotNegative);
    v("range_max_m", range_max_m, kPositive);
    v("metres_per_tick", metres_per_tick, kNotNegative);
    v("track_m", track_m, kNotNegative);
  }
};

/// What a recording of ROS messages lacks, or states wrongly. All of it is detected if possible;
/// table `ros` of `--foreign FILE`, or of NAME.marco.toml next to the recording NAME.
struct RosOptions {
  std::string laser;            ///< a topic; "": the fixed laser that sees most, and one that nods
  std::string odometry;         ///< a topic, "tf" or "none"
  std::string truth;            ///< a topic of poses to compare with
  std::string base_frame;       ///< the robot's, between its wheels
  double wheel_radius_m = 0.0;  ///< of sensor_msgs/JointState, where there is no other odometry
  double wheel_track_m = 0.0;   ///< between the wheels
  bool clockwise = false;       ///< the laser is upside down, and its frame does not say so
  std::string stamp = "first";  ///< the beam that the stamps of scans are of: first, middle or last

  template <class Visitor>
  void visit(Visitor& v) {
    v("laser", laser);
    v("odometry", odometry);
    v("truth", truth);
    v("base_frame", base_frame);
    v("wheel_radius_m", wheel_radius_m, kNotNegative);
    v("wheel_track_m", wheel_track_m, kNotNegative);
    v("clockwise", clockwise);
    v("stamp", stamp);
  }
};

/// The first entry that fits channel and fingerprint applies. config/foreign.toml has the same
/// table, to be extended for other robots (`./marco map --foreign FILE`, and live).
struct ForeignTable {
  std::vector<ForeignChannel> channels = {
      {"RPLIDAR_LASER|LIDAR.*", "89dc5b879a5056cf", "lidar", false, true},
      {".*", "e3d17423180b5e8d", "lidar"},
      {"TRUE_POSE", "1f317af1246276ac", "true_pose"},
      {"MBOT_ODOMETRY|ODOMETRY", "1f317af1246276ac", "odometry"},
      {"MAEBOT_ENCODERS", "7d090bfb221d74f9", "encoders", false, false, 0.05, 30.0, 8.18e-5, 0.082},
      {"POSE|POSE_BODY", "2e16efb052b0105e", "odometry"},
      {".*#sensor_msgs.LaserScan", "8de5754e00f25f00", "lidar"},
      {".*odom.*#nav_msgs.Odometry", "94e17f94648cf0e4", "odometry"},
      {".*odom.*#geometry_msgs.PoseStamped", "6a82696458c279a0", "odometry"},
  };

  RosOptions ros;

  template <class Visitor>
  void visit(Visitor& v) {
    v("channels", channels);
    v("ros", ros);
  }
};

}  // namespace marco
