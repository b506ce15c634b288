#pragma once

#include <vector>

#include "plan/floor_plan.hpp"
#include "plan/free_space.hpp"

namespace marco::plan {

/// The free space, cut at the openings: which cell belongs to which room.
struct RoomRaster {
  std::vector<int> room;     ///< of each cell, -1: none
  std::vector<int> opening;  ///< of each cell, -1: none
  int rooms = 0;
};

/// Keeps the openings that join two rooms of at least 1.5 m2, and closes no others.
RoomRaster cut_rooms(const FreeSpace& space, std::vector<PlanOpening>& openings);

/// A step of a room's outline, 5 cm long.
struct OutlineStep {
  Eigen::Vector2d middle;
  Eigen::Vector2d inward;  ///< unit, averaged over the neighbours
  int outside;             ///< the cell beyond, -1: none
};

/// Around a room, counter-clockwise, then clockwise around each hole that is longer than `least_m`.
std::vector<std::vector<OutlineStep>> outlines_of(const FreeSpace& space,
                                                  const RoomRaster& raster,
                                                  int room,
                                                  double least_m);

/// The cell farthest away from what is not the room.
Eigen::Vector2d inmost_point(const FreeSpace& space, const RoomRaster& raster, int room);

}  // namespace marco::plan
