#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "slam/map/keyframe_grid.hpp"
#include "slam/process/checkpoint.hpp"
#include "slam/process/loop_worker.hpp"
#include "slam/process/mapper2d_adapter.hpp"
#include "slam/session/mapping_session.hpp"

namespace marco::slam {

struct SlamAdapterOptions : Mapper2dAdapterOptions {
  SlamOptions slam;
  LocalizerOptions localizer;
  /// Live: loops found by the second thread are accepted this long after they were searched for, in
  /// message time, so that a run does not depend on the machine's load; later only when the search
  /// takes longer.
  double loop_delay_s = 1.0;
  double path_every_m = 0.05;  ///< live: poses nearer to each other are not kept, see Slam

  template <class Visitor>
  void visit(Visitor& v) {
    v("slam", slam);
    v("localizer", localizer);
    Mapper2dAdapterOptions::visit(v);
    v.advanced("path_every_m", path_every_m, kNotNegative,
               "Live poses nearer to each other than this are dropped. Less for a finer path, at "
               "the cost of memory.");
  }
};

/// Scan SLAM's adapter: publishes GRID_MAP in addition to the outputs of every Mapper2dAdapter, and
/// resumes from options.checkpoint_path when that file exists; one that cannot be read is put
/// aside.
///
/// Live, after close_loops_in_background(), no scan waits for a loop search, an optimization or the
/// disk:
///   scans -> [this thread: match, publish] -> LoopWork -> [LoopWorker's thread] -> accept()
/// The result is accepted before the first scan options.loop_delay_s later. On a machine that needs
/// longer it is accepted later: only then poses depend on the machine's speed, and late_loop_work()
/// counts how often. Batch runs close loops at once.
class SlamAdapter : public Mapper2dAdapter {
 public:
  /// @param bus outlives the adapter.
  /// @param warn  see process::DropCounter.
  SlamAdapter(process::Bus& bus,
              const SlamAdapterOptions& options,
              const std::function<void(const std::string&)>& warn = {});

  /// See above. Not to be undone. Keeps a short path from here on.
  void close_loops_in_background();
  /// No path is kept that grows with time: live_trajectory() and odometry_trajectory() end here,
  /// and that of Slam follows the map. Poses do not change. Not to be undone.
  void keep_short_path();

  /// From here on scans and loops are used as these say; a batch run's, since live loops are
  /// searched elsewhere.
  void set_edits(const MapEdits& edits);

  /// Continues a saved map, once it is relocalized in it; or localizes in it, changing nothing.
  /// @throws std::invalid_argument for a map that holds nothing to find a place by.
  void extend(SavedMap map) { session_.extend(std::move(map)); }
  void localize(SavedMap map) { session_.localize(session_.localizer_in(std::move(map))); }
  /// Localizing: the robot is here, and is not searched.
  void set_pose(const Pose2& map_from_robot) { session_.set_pose(map_from_robot); }

  /// Everything it knows; what restore() takes continues as if it had never stopped. Mapping only.
  AdapterState state() const;
  void restore(AdapterState state);
  /// Resumes a map after a stop, once scans have shown that the robot is in it: see
  /// MappingSession::resume. One that is not found within a drive begins a new map; the other is
  /// put aside, among the saved maps. @throws std::invalid_argument for a map without a place.
  void resume(AdapterState state);
  /// The newest state, onto the disk: SLAM was ended on purpose.
  void end_checkpoint();
  int64_t late_loop_work() const { return late_loop_work_; }

  const MappingSession& session() const { return session_; }
  const Slam& slam() const { return session_.slam(); }
  const Mapper2d& mapper2d() const override { return session_; }

 private:
  MappedScan map_scan(const SynchronizedScan& scan, bool may_draw) override;
  void publish_map(Utime utime) override;
  void start_mapper_session() override { session_.start_session(); }
  void finish_mapping() override;
  std::string execute_on_map(const SlamOrder& order) override;
  std::function<void()> checkpoint_job() override;
  std::string mapping_line() const override;
  void restore_input(AdapterState& state);
  void give_up_resuming();

  /// A scan, and what it was asked to do.
  struct DoubtfulScan {
    SynchronizedScan scan;
    bool may_draw;
  };
  void note_doubtful(const SynchronizedScan& scan, bool may_draw);
  /// From the first scan on, by beams of another order than they were mapped by.
  MappedScan map_again(BeamOrder order);

  /// @returns whether older poses moved.
  bool exchange_loop_work(Utime utime);
  /// Says once that a part of the map is left out.
  void note_size(const OccupancyGrid& grid);
  std::string save(const std::filesystem::path& folder);

  SlamAdapterOptions options_;
  MappingSession session_;
  MapEdits edits_;
  /// All scans so far; none once the order of their beams is known, or they are too many.
  std::vector<DoubtfulScan> doubtful_;
  KeyframeGrid grid_;                        ///< as last published
  bool too_large_ = false;                   ///< as reported by note_size()
  std::unique_ptr<LoopWorker> loop_worker_;  ///< nullptr: each scan waits for its loops
  bool scan_is_level_ = true;                ///< the newest one
  Utime loop_work_asked_;
  bool loop_work_is_late_ = false;
  int64_t late_loop_work_ = 0;
};

}  // namespace marco::slam
