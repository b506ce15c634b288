#pragma once

#include <array>
#include <string>

#include "lcm_tools/base/renamed_key.hpp"
#include "slam/line_slam/line_mapper.hpp"
#include "slam/process/mapper2d_adapter.hpp"

namespace marco::slam {

/// [slam] for a mapper that keeps all its keyframes: the filter is replayed along them.
struct UnculledSlamOptions {
  SlamOptions& slam;

  static constexpr auto kRenamed = SlamOptions::kRenamed;
  template <class Visitor>
  void visit(Visitor& v) {
    slam.visit_without_culling(v);
  }
};

/// All settings of marco-line-slam.
struct LineProcessOptions : Mapper2dAdapterOptions {
  LineMapperOptions mapper;
  std::string journal_path;  ///< JSON lines; "" = none

  static constexpr std::array kRenamed{
      RenamedKey{"mapper", "lines"}, RenamedKey{"range_sigma_m", "lines.extraction.range_sigma_m"},
      RenamedKey{"keyframe_distance_m", "slam.keyframe_distance_m"},
      RenamedKey{"keyframe_turn_deg", "slam.keyframe_turn_deg"}, RenamedKey{"grid", "slam.grid"}};

  template <class Visitor>
  void visit(Visitor& v) {
    v("lines", mapper);
    UnculledSlamOptions slam{mapper.slam};
    v("slam", slam);
    Mapper2dAdapterOptions::visit(v);
    v.advanced("journal_path", journal_path,
               "File for a line of JSON for each step of the filter; empty: none.");
  }
};

}  // namespace marco::slam
