#pragma once

#include <fstream>
#include <functional>
#include <optional>

#include "slam/line_slam/line_mapper.hpp"
#include "slam/process/line_checkpoint.hpp"
#include "slam/process/line_process_options.hpp"
#include "slam/process/mapper2d_adapter.hpp"

namespace marco::slam {

/// Line SLAM's adapter: publishes LINE_MAP in addition to the outputs of every Mapper2dAdapter, and
/// resumes from options.checkpoint_path when that file exists.
///
/// Of tilted scans only the pose is predicted.
class LineSlamAdapter : public Mapper2dAdapter {
 public:
  /// @throws std::invalid_argument for a bad option or a damaged checkpoint.
  /// @param bus outlives the adapter. @param warn  see process::DropCounter.
  LineSlamAdapter(const LineProcessOptions& options,
                  process::Bus& bus,
                  std::function<void(const std::string&)> warn = {});

  void finish() override;
  /// Live: no scan waits for the disk.
  void save_in_background() { write_in_background(); }

  int64_t scans_used() const { return scans_used_; }
  LineMapper& mapper() { return mapper_; }
  const LineMapper& mapper() const { return mapper_; }
  const Mapper2d& mapper2d() const override { return mapper_; }

 private:
  MappedScan map_scan(const SynchronizedScan& scan, bool may_draw) override;
  void publish_map(Utime utime) override;
  void start_mapper_session() override { mapper_.forget_motion(); }
  void finish_mapping() override { mapper_.finish(); }
  std::string execute_on_map(const SlamOrder& order) override;
  std::function<void()> checkpoint_job() override;
  std::string mapping_line() const override;

  LineCheckpoint checkpoint();
  void reset(const Pose2& world_from_robot);

  LineProcessOptions options_;
  LineMapper mapper_;
  std::optional<Utime> last_scan_;  ///< its repaired stamp
  std::ofstream journal_;
  int64_t map_revision_ = 0;
  int64_t scans_used_ = 0;
};

}  // namespace marco::slam
