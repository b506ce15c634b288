#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "slam/back_end/graph/joint_refinement.hpp"
#include "slam/back_end/graph/pose_graph.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/back_end/loop_work.hpp"
#include "slam/back_end/marginalization.hpp"
#include "slam/map/keyframe_culling.hpp"
#include "slam/map/map_edit.hpp"

namespace marco::slam {

struct BackEndState {
  std::vector<PoseGraphEdge> edges;
  std::vector<Loop> loops;              ///< one for each loop edge, in their order
  double next_search_path_m = 0.0;      ///< when loops are searched again
  double closed_path_m = 0.0;           ///< when a loop was last closed
  std::vector<double> loop_closings_m;  ///< the same of the last loops

  template <class Visitor>
  void visit(Visitor& v) {
    v("edges", edges);
    v("loops", loops);
    v("next_search_path_m", next_search_path_m);
    v("closed_path_m", closed_path_m);
    v("loop_closings_m", loop_closings_m);
  }
};

/// @throws std::invalid_argument for an edge or loop that ends at no keyframe or is longer than any
/// building, or loops that are not one for each loop edge.
void check(const BackEndState& state, const KeyframeSet& keyframes);

/// The back end: the pose graph's edges between keyframes, loop closures, and the optimization. Its
/// nodes are the keyframes, whose poses are not kept here. Not thread-safe.
class BackEnd {
 public:
  BackEnd(const LoopCloser& loop_closer,
          const PoseGraphOptions& graph,
          const JointRefinementOptions& refinement);

  const BackEndState& state() const { return state_; }
  void restore(const BackEndState& state);
  const std::vector<Loop>& loops() const { return state_.loops; }
  const LoopCloser& loop_closer() const { return loop_closer_; }
  /// From here on no loop is looked for that these forbid.
  void set_edits(const MapEdits& edits) { edits_ = edits; }

  void add_edge(const PoseGraphEdge& edge) { state_.edges.push_back(edge); }
  void add_loop(const Loop& loop);
  /// Another session's edges and loops, whose keyframes follow those that are there.
  void append(const BackEndState& session, int first_key);
  void note_search(double path_m) {
    state_.next_search_path_m = path_m + loop_closer_.options().attempt_every_m;
  }
  void note_closing(double path_m) { state_.closed_path_m = path_m; }

  /// See Slam::defer_loop_work.
  void defer_work() { deferred_ = true; }
  bool is_deferred() const { return deferred_; }
  /// Work is done elsewhere: keyframes must keep their numbers.
  bool is_busy() const { return work_is_out_; }
  /// Makes work for the newest keyframe, if it is time for some. @param robust  see LoopWork
  bool prepare_work(const std::vector<Keyframe>& keys, bool robust);
  /// Prepared work, once.
  std::optional<LoopWork> take_work();
  /// @returns poses of all keyframes where they have moved; those that came meanwhile follow the
  /// newest that was there. Nothing for work taken before a restore().
  std::optional<std::vector<Pose2>> accept(const LoopWork& work, const std::vector<Keyframe>& keys);

  /// Whether loops were closed shortly before and after this place on the path. Call with ascending
  /// places: closings before them are forgotten.
  bool has_loops_around(double path_m);
  /// Those that the edits forbid.
  void remove_loops(const MapEdits& edits, const std::vector<Keyframe>& keys);
  void merge_node(int key, const MergedKeyframe& merged);

  /// The poses of all keyframes, optimized from where they lie.
  std::vector<Pose2> optimized(const std::vector<Keyframe>& keys) const;
  /// The same with robust loops, all keyframes refined jointly.
  std::vector<Pose2> finish(const std::vector<Keyframe>& keys, JointRefinementResult& result);

 private:
  /// See LoopCloser::find.
  std::vector<RelativeUncertainty> uncertainties_of_newest(const std::vector<Keyframe>& keys) const;
  PoseGraph graph_of(const std::vector<Keyframe>& keys) const;
  void remove_outliers(const LoopWork& work);
  void keep_edges(const std::function<bool(std::size_t)>& is_kept);

  LoopCloser loop_closer_;
  PoseGraphOptions graph_options_;
  JointRefinementOptions refinement_options_;
  BackEndState state_;
  bool deferred_ = false;
  bool work_is_out_ = false;
  std::optional<LoopWork> work_;  ///< to be taken
  MapEdits edits_;
};

}  // namespace marco::slam
