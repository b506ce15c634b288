#pragma once

#include <array>
#include <string>

#include "lcm_tools/base/renamed_key.hpp"
#include "slam/line_slam/line_mapper.hpp"
#include "slam/process/mapper2d_adapter.hpp"

namespace marco::slam {

/// Everything marco-line-slam can be told.
struct LineProcessOptions : Mapper2dAdapterOptions {
  LineMapperOptions mapper;
  double max_speed_m_per_s = 5.0;  ///< odometry that jumps faster is not believed
  std::string journal_path;        ///< JSON lines; "" = none

  static constexpr std::array kRenamed{
      RenamedKey{"mapper", "lines"}, RenamedKey{"range_sigma_m", "lines.extraction.range_sigma_m"}};

  template <class Visitor>
  void visit(Visitor& v) {
    v("lines", mapper);
    mapper.keyframes.visit(v);
    v("grid", mapper.grid);
    Mapper2dAdapterOptions::visit(v);
    v.advanced("max_speed_m_per_s", max_speed_m_per_s, kPositive,
               "Odometry that jumps faster is rejected. More for a faster robot.");
    v.advanced("journal_path", journal_path,
               "File for a line of JSON for each step of the filter; empty: none.");
  }
};

}  // namespace marco::slam
