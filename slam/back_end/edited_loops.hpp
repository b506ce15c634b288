#pragma once

#include <vector>

#include "slam/back_end/graph/pose_graph_edge.hpp"
#include "slam/map/map_edit.hpp"
#include "slam/map/scan_path.hpp"

namespace marco::slam {

/// The loops that a person adds to a map (MapEdit::add_loop). Each becomes an edge as soon as the
/// scan of its later end has come: no loop, for nothing may find it wrong.
class EditedLoops {
 public:
  void set(const MapEdits& edits);

  /// Edges of the loops whose later end is there now, each once. A loop whose ends lie at no scan,
  /// or in one keyframe, is left out. @param path  its newest scan is the last one
  std::vector<PoseGraphEdge> take_due(const std::vector<ScanPose>& path);

 private:
  MapEdits waiting_;
};

}  // namespace marco::slam
