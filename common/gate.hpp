#pragma once

namespace marco {

/// A threshold that decides. Each is in a table next to the code that uses it; docs/gates.md is
/// printed from these tables.
struct Gate {
  const char* name;
  const char* quantity;  ///< what is held against the threshold, with its unit
  double threshold;
  const char* consequence;  ///< what happens beyond it
  const char* source;       ///< where the value comes from
};

}  // namespace marco
