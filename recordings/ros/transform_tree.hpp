#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recordings/ros/messages.hpp"

namespace marco::ros {

/// How one frame was seen in its parent over a whole recording.
struct FrameEdge {
  std::string parent, child;
  Pose3 parent_from_child = Pose3::Identity();  ///< the first; of static transforms the last
  double moved_m = 0.0, turned_rad = 0.0;       ///< at most, from the first
  int64_t count = 0;
  bool is_static = false;  ///< announced so, on /tf_static

  /// What is published again and again where nothing moves is constant, too.
  bool moves() const { return !is_static && (moved_m > 0.002 || turned_rad > 0.003); }
};

/// The frames of a robot: all transforms of a recording, gathered before any of them is used, since
/// latched ones may be stamped hours before the first scan and others come late. As tf2 does, it
/// drops self-transforms, frames without a name and quaternions that are not a rotation.
class TransformTree {
 public:
  void add(const TransformMessage& transform, bool is_static);

  /// The edge above a frame. Of several parents: the one that stays fixed, else the one seen most
  /// often.
  const FrameEdge* above(const std::string& child) const;
  bool contains(const std::string& frame) const;
  /// The edges from a frame up to its root, the frame's own first.
  std::vector<const FrameEdge*> way_up(const std::string& frame) const;
  /// Pose of a frame in another one, where no edge between them moves.
  std::optional<Pose3> fixed_pose(const std::string& in, const std::string& frame) const;
  /// All edges.
  std::vector<const FrameEdge*> edges() const;

 private:
  std::map<std::pair<std::string, std::string>, FrameEdge> edges_;  // by child and parent
};

}  // namespace marco::ros
