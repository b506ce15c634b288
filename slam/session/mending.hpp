#pragma once

#include "slam/map/map_edit.hpp"
#include "slam/slam.hpp"

namespace marco::slam {

/// Mends a finished map where it contradicts itself (see find_visits()): the doctor's remedies are
/// tried, loop closures that the search missed and others that are in force and wrong. Each try
/// ends with Slam::finish(), and is undone unless more points agree and a smaller share of them
/// contradicts.
///
/// It is the second half of loop closing: the search is as wide as the graph believes itself to be
/// off, and where a prediction was surer than it was good, only the walls themselves show it.
/// Cost: that of the doctor's look at the map; a try more costs as much, and a Slam::finish().
/// @returns what was done, one loop each; nothing for a map that agrees with itself.
MapEdits mend(Slam& slam);

}  // namespace marco::slam
