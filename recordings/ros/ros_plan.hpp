#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "recordings/foreign.hpp"
#include "recordings/ros/ros_survey.hpp"
#include "recordings/ros/transform_tree.hpp"

namespace marco::ros {

/// A joint between the robot and a laser, as a transform that moves.
struct Joint {
  std::string parent, child;  ///< frames
};

/// Whether a name holds one of the words, in capitals or not.
bool has(const std::string& name, std::initializer_list<const char*> words);

/// What simulators and motion capture publish as odometry.
bool names_truth(const std::string& name);

/// Another mapper's or localizer's result jumps, and is no odometry.
bool is_map_frame(const std::string& frame);

/// How sensors are fixed to a robot, by its frames.
class SensorMounts {
 public:
  /// @param tree  must outlive it
  explicit SensorMounts(const TransformTree& tree) : tree_(tree) {}

  /// The first moving transform above a sensor that is a joint of the robot.
  std::optional<Joint> joint_above(const std::string& frame) const;
  /// By transforms that do not move, but for one joint.
  bool is_on_robot(const std::string& base, const std::string& sensor) const;
  /// The highest of the frames above a sensor that belong to its robot; "" none.
  std::string highest_on_robot(const std::string& frame) const;

 private:
  bool is_fixed_to(const std::string& a, const std::string& b) const;

  const TransformTree& tree_;
};

/// Joints of one topic of sensor_msgs/JointState, by name; "" none.
struct PanTiltJoints {
  std::string topic, pan, tilt;
};
struct WheelJoints {
  std::string topic, left, right;
};

/// The joints that move a laser, where their names or the laser's say so.
std::optional<PanTiltJoints> pantilt_joints(const RosSurvey& survey, const SurveyedTopic& laser);

/// Two wheels that turn, of which the names differ by "left" and "right".
std::optional<WheelJoints> wheel_joints(const RosSurvey& survey);

/// A laser that is used.
struct LaserPlan {
  std::string topic, frame;
  bool is_cloud = false;
  bool tells_beam_times = false;  ///< one a beam: the laser sees all round
  SensorInfo info;
  std::string scan_channel;  ///< info.channel, or that of scans with beam times
  double duration_s = 0.0;   ///< first beam to last; 0 = not known
  BearingGrid bearings;      ///< of a cloud
};

/// Keys of RosPlan::shift_ns: the transform that is odometry, and that of a joint.
inline constexpr const char* kTfClock = "tf";
inline constexpr const char* kJointClock = "joint";

/// What is taken from a recording of ROS messages, and as what.
struct RosPlan {
  std::vector<LaserPlan> lasers;                ///< the first one's clock is the recording's
  std::vector<Joint> joints;                    ///< of a pan-tilt, by tf
  std::optional<PanTiltJoints> pantilt_joints;  ///< the same by joint states
  std::optional<SensorInfo> pantilt;
  std::string base_frame;             ///< "" where the laser is the robot
  std::string odometry_topic;         ///< "" none
  std::string odometry_parent;        ///< of the transform that is odometry where there is no topic
  std::optional<WheelJoints> wheels;  ///< that are odometry where there is neither
  std::string imu_topic;
  Pose3 base_from_imu = Pose3::Identity();
  double rad_per_imu_unit = 1.0;  ///< of its rates
  std::string truth_topic;
  /// Added to the stamps of a topic, or of one of the clocks below: to the laser's clock.
  std::map<std::string, int64_t> shift_ns;
  int64_t received_shift_ns = 0;   ///< the same of times of receipt
  std::vector<std::string> notes;  ///< what was decided, a sentence each

  /// Adds to the notes in the style of printf.
  [[gnu::format(printf, 2, 3)]] void note(const char* format, ...);
  bool uses_laser(const std::string& topic) const;
  /// Whether it is a topic of joint states that is read.
  bool uses_joints(const std::string& topic) const;
};

/// @throws std::invalid_argument "no laser: ..." with what there is instead.
RosPlan plan_of(const RosSurvey& survey, const RosOptions& options);

}  // namespace marco::ros
