#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "recordings/ros/bearing_grid.hpp"
#include "recordings/ros/message_source.hpp"
#include "recordings/ros/messages.hpp"
#include "recordings/ros/transform_tree.hpp"

namespace marco::ros {

/// The times from a sender's stamps to the recorder, which tell its clock from others': the least
/// of every five seconds, that no queue adds to. They grow where time is simulated slowly.
class StampDelays {
 public:
  void add(int64_t received_ns, int64_t stamp_ns);
  bool empty() const { return least_s_.empty(); }
  /// [s]; 0 where nothing is known.
  double least_s() const;
  /// By how much longer they are than another sender's of the same time: its clock is ahead of
  /// this one by so much.
  double longer_s(const StampDelays& other) const;

 private:
  std::map<int64_t, double> least_s_;  // by the part of the recording
};

/// The angles of a joint over a recording.
struct SurveyedJoint {
  double least_rad = 0.0, most_rad = 0.0;
};

/// Results of a first pass for a topic.
struct SurveyedTopic {
  std::string name, type;
  Use use = Use::none;
  int64_t count = 0;
  int64_t undecodable = 0;
  std::string frame_id, child_frame_id;  ///< of the first message
  int64_t zero_stamps = 0;
  StampDelays delays;     ///< of messages that are stamped
  double period_s = 0.0;  ///< median of the times between stamps
  double way_m = 0.0;     ///< of poses
  double turned_rad = 0.0;
  LaserScanMessage first_scan;  ///< without ranges
  std::size_t beams = 0;
  BearingGrid bearings;  ///< of a flat cloud
  /// Of scans: this range [m] and more piles up, so that it is no return; 0: none does.
  double no_return_m = 0.0;
  std::map<std::string, SurveyedJoint> joints;  ///< by name
  double fastest_turn = 0.0;                    ///< of a gyroscope, in its unit
  bool is_flat = true;  ///< of a cloud: all points in the plane of its frame
};

struct RosSurvey {
  /// "it holds /scan (sensor_msgs/LaserScan), ...".
  std::string contents() const;

  std::map<std::string, SurveyedTopic> topics;  ///< by name
  TransformTree tree;
  /// Of each transform, by child and parent.
  std::map<std::pair<std::string, std::string>, StampDelays> transform_delays;
};

/// For a note.
inline const char* name_or_none(const std::string& frame) {
  return frame.empty() ? "(no frame)" : frame.c_str();
}

/// Reads the whole recording once, but for pictures and the like.
RosSurvey survey(MessageSource& source);

}  // namespace marco::ros
