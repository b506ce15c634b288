#pragma once

#include <string>

#include "plan/known_plan/deviations.hpp"
#include "plan/known_plan/known_plan.hpp"

namespace marco::plan {

/// For people: what is off the plan, what is missing, what is not drawn, and how many walls agree.
std::string deviation_table(const PlanDeviations& deviations);

/// {"plan": {"unit_m", "layers_taken", "layers_passed_over"}, "drawing_from_map": {"x_m", "y_m",
/// "theta_rad"}, "spread_m", "axis_thickness_m", "agreeing", "walls": [{"wall", "state", "room",
/// "from_m", "to_m", "length_m", "off_m", "sigma_m", "turn_deg", "is_off", "seen_m", "gone_m"; of a
/// curve "shift_m"}], "not_drawn": [{"from_m", "to_m", "length_m", "room", "furniture",
/// "before_wall"}]}; frame: the drawing's.
std::string deviations_json(const PlanDeviations& deviations, const KnownPlan& plan);

/// The plan (grey) and the measured walls (green; red where off the plan) on top of each other,
/// what is missing (dashed) and what is not drawn (blue; furniture pale), with the walls' numbers.
std::string deviations_svg(const PlanDeviations& deviations, const KnownPlan& plan);

}  // namespace marco::plan
