#pragma once

#include <string>

#include "slam/line_slam/line_mapper.hpp"
#include "slam/process/mapper2d_adapter.hpp"

namespace marco::slam {

/// Everything marco-line-slam can be told.
struct LineProcessOptions : Mapper2dAdapterOptions {
  LineMapperOptions mapper;
  double range_sigma_m = 0.01;     ///< where SENSOR_INFO gives none
  double max_speed_m_per_s = 5.0;  ///< odometry that jumps faster is not believed
  std::string journal_path;        ///< JSON lines; "" = none

  template <class Visitor>
  void visit(Visitor& v) {
    v("mapper", mapper);
    Mapper2dAdapterOptions::visit(v);
    v("range_sigma_m", range_sigma_m, kPositive);
    v("max_speed_m_per_s", max_speed_m_per_s, kPositive);
    v("journal_path", journal_path);
  }
};

}  // namespace marco::slam
