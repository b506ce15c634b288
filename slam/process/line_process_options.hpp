#pragma once

#include <string>

#include "slam/line_slam/line_mapper.hpp"

namespace marco::slam {

/// Everything marco-line-slam can be told.
struct LineProcessOptions {
  LineMapperOptions mapper;
  std::string lidar_channel = "LIDAR";
  double range_sigma_m = 0.01;     ///< where SENSOR_INFO gives none
  double max_tilt_deg = 1.0;       ///< scans tilted more are not for the plan
  double max_speed_m_per_s = 5.0;  ///< odometry that jumps faster is not believed
  double odometry_wait_s = 0.5;    ///< a scan waits so long (of log time) for its odometry
  double map_every_s = 5.0;        ///< LINE_MAP is sent this often
  std::string checkpoint_path;     ///< "" = none is written or read
  double checkpoint_every_s = 30.0;
  std::string save_folder;   ///< SLAM_COMMAND may save within it; "" = nowhere
  std::string journal_path;  ///< JSON lines; "" = none
  int hold_out_every = 0;    ///< every Nth scan gets a pose but is not drawn; 0 = none

  template <class Visitor>
  void visit(Visitor& v) {
    v("mapper", mapper);
    v("lidar_channel", lidar_channel);
    v("range_sigma_m", range_sigma_m, kPositive);
    v("max_tilt_deg", max_tilt_deg, Limits{0.0, 90.0});
    v("max_speed_m_per_s", max_speed_m_per_s, kPositive);
    v("odometry_wait_s", odometry_wait_s, kNotNegative);
    v("map_every_s", map_every_s, kPositive);
    v("checkpoint_path", checkpoint_path);
    v("checkpoint_every_s", checkpoint_every_s, kPositive);
    v("save_folder", save_folder);
    v("journal_path", journal_path);
    v("hold_out_every", hold_out_every, Limits{0, 1000000});
  }
};

}  // namespace marco::slam
