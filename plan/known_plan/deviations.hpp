#pragma once

#include <string>
#include <vector>

#include "plan/known_plan/plan_fit.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::plan {

/// What was measured of a side of a drawn wall.
struct WallDeviation {
  enum class State {
    measured,
    missing,  ///< beams went through where it is drawn
    unseen    ///< nobody looked there
  };
  int number = 0;                ///< from 1, in the order of the table
  std::vector<DrawnFace> drawn;  ///< one, or the chords of a curve
  State state = State::unseen;
  std::string room;    ///< that it faces; "" where none was measured there
  double off_m = 0.0;  ///< into the room, at the middle of what was seen; of a curve, outwards from
                       ///< what is drawn on the side it is seen from
  double sigma_m = 0.0;              ///< of that
  double turn_rad = 0.0;             ///< against the drawn direction; 0 of a curve
  Eigen::Vector2d shift_m = {0, 0};  ///< of a curve: its centre
  double seen_m = 0.0;               ///< of its length
  double gone_m = 0.0;               ///< of its length, that beams went through

  double length_m() const;
  bool is_curve() const { return drawn.front().curved; }
  /// Beyond three standard deviations, and 2 cm, which builders are allowed.
  bool is_off() const;
  /// Half a metre or more of it is not there.
  bool has_gap() const { return gone_m >= 0.5; }
};

/// A measured face that nothing drawn explains.
struct UndrawnWall {
  WallFace face;  ///< in the drawing
  std::string room;
  bool furniture = false;  ///< or a column: up to 3 m large, free or before a wall that continues
  int before = 0;          ///< number of the drawn wall that it stands before; 0: none
};

struct PlanDeviations {
  PlanFit fit;
  /// The plan draws walls as one line, which lies in their middle: so thick they are, the median.
  /// Deviations are then those of the middle; of a wall whose other side was not measured, with
  /// this thickness. 0 where faces are drawn.
  double axis_thickness_m = 0.0;
  std::vector<WallDeviation> walls;
  std::vector<UndrawnWall> undrawn;
};

/// Compares a finished map with a plan. The map is laid into the plan by one rigid move
/// (fit_to_plan); deviations are of faces as make_plan() finds them, and their sigma holds the
/// face's own, the fit's, and the spread of the walls that agree. Faces shorter than 0.3 m are not
/// compared. @param keys  of the map. @throws as make_plan() and fit_to_plan().
PlanDeviations compare_with_plan(const std::vector<DrawnFace>& drawn,
                                 const std::vector<slam::Keyframe>& keys,
                                 const Pose2& drawing_from_map_guess);

}  // namespace marco::plan
