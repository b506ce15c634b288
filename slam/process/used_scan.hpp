#pragma once

#include "common/input/deskew.hpp"

namespace marco::slam {

/// What became of a scan, for those who draw or judge the map afterwards.
struct UsedScan {
  DeskewedScan deskewed;  ///< its points may have been dropped: see keep_scans()
  bool level = true;
  bool held_out = false;
  bool matched = false;

  template <class Visitor>
  void visit(Visitor& v) {
    v("deskewed", deskewed);
    v("level", level);
    v("held_out", held_out);
    v("matched", matched);
  }
};

}  // namespace marco::slam
