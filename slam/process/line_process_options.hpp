#pragma once

#include <string>

#include "slam/line_slam/line_mapper.hpp"
#include "slam/process/mapper2d_adapter.hpp"

namespace marco::slam {

/// [slam] for a mapper that keeps all its keyframes: the filter is replayed along them.
struct UnculledSlamOptions {
  SlamOptions& slam;

  template <class Visitor>
  void visit(Visitor& v) {
    slam.visit_without_culling(v);
  }
};

/// All settings of marco-line-slam.
struct LineProcessOptions : Mapper2dAdapterOptions {
  LineMapperOptions mapper;
  std::string journal_path;  ///< JSON lines; "" = none

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
