#include "plan/known_plan/deviation_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/files/metre_svg.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::plan {
namespace {

using Json = nlohmann::ordered_json;
using Vector = Eigen::Vector2d;
using State = WallDeviation::State;

double rounded(double value) { return std::round(value * 1e4) / 1e4 + 0.0; }
Json at(const Vector& point) { return {rounded(point.x()), rounded(point.y())}; }

Vector begin_of(const WallDeviation& wall) {
  return wall.drawn.front().face.at(wall.drawn.front().face.low_m);
}
Vector end_of(const WallDeviation& wall) {
  return wall.drawn.back().face.at(wall.drawn.back().face.high_m);
}

const char* name_of(State state) {
  return state == State::measured ? "measured" : state == State::missing ? "missing" : "unseen";
}

std::string place_of(const WallDeviation& wall) {
  const Vector a = begin_of(wall), b = end_of(wall);
  return format("wall %d (%.1f m, %s%s, from %.2f %.2f to %.2f %.2f)", wall.number, wall.length_m(),
                wall.is_curve() ? "curved, " : "",
                wall.room.empty() ? "outside" : (wall.room + " side").c_str(), a.x(), a.y(), b.x(),
                b.y());
}

std::string line_of(const WallDeviation& wall) {
  std::string line = place_of(wall);
  if (wall.state == State::missing) return line + ": is missing";
  if (wall.is_off() && wall.is_curve()) {
    line += format(": %.1f cm off the plan (its centre by %.1f %.1f cm, %.1f cm outwards)",
                   100 * std::max(wall.shift_m.norm(), std::abs(wall.off_m)),
                   100 * wall.shift_m.x(), 100 * wall.shift_m.y(), 100 * wall.off_m);
  } else if (wall.is_off()) {
    line += format(": %.1f cm off the plan, %s the room", 100 * std::abs(wall.off_m),
                   wall.off_m > 0 ? "into" : "away from");
  }
  if (wall.is_off()) line += format(", sigma %.1f cm", 100 * wall.sigma_m);
  if (wall.has_gap()) line += format(": %.1f m of it are missing", wall.gone_m);
  return line;
}

}  // namespace

std::string deviation_table(const PlanDeviations& deviations) {
  std::string off, missing, unseen, agree;
  int agreeing = 0, not_seen = 0;
  double squares = 0.0, not_seen_m = 0.0;
  for (const WallDeviation& wall : deviations.walls) {
    if (wall.is_off()) off += "  " + line_of(wall) + "\n";
    if (!wall.is_off() && (wall.state == State::missing || wall.has_gap())) {
      missing += "  " + line_of(wall) + "\n";
    }
    if (wall.state == State::measured && !wall.is_off()) {
      ++agreeing;
      squares += wall.off_m * wall.off_m;
    }
    if (wall.state == State::unseen) ++not_seen, not_seen_m += wall.length_m();
  }
  std::string more;
  int furniture = 0;
  for (const UndrawnWall& wall : deviations.undrawn) {
    if (wall.furniture) {
      ++furniture;
      continue;
    }
    const Vector a = wall.face.at(wall.face.low_m), b = wall.face.at(wall.face.high_m);
    std::string line =
        format("  %.1f m, %s, from %.2f %.2f to %.2f %.2f", wall.face.length_m(),
               wall.room.empty() ? "outside" : wall.room.c_str(), a.x(), a.y(), b.x(), b.y());
    if (wall.before > 0) line += format(", in front of wall %d", wall.before);
    more += line + "\n";
  }
  const auto part = [](const char* title, const std::string& lines) {
    return lines.empty() ? std::string() : title + ("\n" + lines);
  };
  std::string table;
  if (deviations.axis_thickness_m > 0) {
    table = format("the plan draws the walls' middle lines; they are %.1f cm thick (median)\n",
                   100 * deviations.axis_thickness_m);
  }
  table += part("off the plan:", off) + part("drawn, but missing:", missing) +
           part("present, but not drawn:", more);
  table += format("%d walls' sides agree with the plan, %.1f cm rms", agreeing,
                  agreeing > 0 ? 100 * std::sqrt(squares / agreeing) : 0.0);
  if (not_seen > 0) table += format("; %d (%.1f m) were not seen", not_seen, not_seen_m);
  if (furniture > 0) {
    table += format("; %d faces of furniture and columns are not compared", furniture);
  }
  return table + "\n";
}

std::string deviations_json(const PlanDeviations& deviations, const KnownPlan& plan) {
  Json json;
  json["plan"] = {{"unit_m", plan.unit_m},
                  {"layers_taken", plan.taken},
                  {"layers_passed_over", plan.passed_over}};
  const Pose2& pose = deviations.fit.drawing_from_map;
  json["drawing_from_map"] = {{"x_m", pose.x_m}, {"y_m", pose.y_m}, {"theta_rad", pose.theta_rad}};
  json["spread_m"] = rounded(deviations.fit.spread_m);
  json["axis_thickness_m"] = rounded(deviations.axis_thickness_m);
  json["agreeing"] = rounded(deviations.fit.agreeing);
  json["walls"] = Json::array();
  for (const WallDeviation& wall : deviations.walls) {
    Json entry = {{"wall", wall.number},
                  {"state", name_of(wall.state)},
                  {"room", wall.room},
                  {"from_m", at(begin_of(wall))},
                  {"to_m", at(end_of(wall))},
                  {"length_m", rounded(wall.length_m())},
                  {"seen_m", rounded(wall.seen_m)},
                  {"gone_m", rounded(wall.gone_m)}};
    if (wall.state == State::measured) {
      entry["off_m"] = rounded(wall.off_m);
      entry["sigma_m"] = rounded(wall.sigma_m);
      entry["is_off"] = wall.is_off();
      if (wall.is_curve()) {
        entry["shift_m"] = at(wall.shift_m);
      } else {
        entry["turn_deg"] = rounded(wall.turn_rad * 180 / std::numbers::pi);
      }
    }
    json["walls"].push_back(std::move(entry));
  }
  json["not_drawn"] = Json::array();
  for (const UndrawnWall& wall : deviations.undrawn) {
    json["not_drawn"].push_back({{"from_m", at(wall.face.at(wall.face.low_m))},
                                 {"to_m", at(wall.face.at(wall.face.high_m))},
                                 {"length_m", rounded(wall.face.length_m())},
                                 {"room", wall.room},
                                 {"furniture", wall.furniture},
                                 {"before_wall", wall.before}});
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string deviations_svg(const PlanDeviations& deviations, const KnownPlan& plan) {
  files::MetreSvg svg({plan.low_m(), plan.high_m()},
                      "line{stroke-width:0.04;stroke-linecap:round;fill:none}"
                      ".drawn{stroke:#999;stroke-width:0.02}.agrees{stroke:#0a7d24}"
                      ".off{stroke:#c0281c;stroke-width:0.06}"
                      ".missing{stroke:#c0281c;stroke-dasharray:0.12 0.12}"
                      ".more{stroke:#1d5fc2}.furniture{stroke:#9dbde8}"
                      "text{font:0.25px sans-serif;fill:#c0281c}");
  for (const KnownPlan::Line& line : plan.lines) svg.line("class=\"drawn\"", line.from, line.to);
  for (const WallDeviation& wall : deviations.walls) {
    for (const DrawnFace& piece : wall.drawn) {
      const WallFace& drawn = piece.face;
      if (wall.state == State::missing) {
        svg.line("class=\"missing\"", drawn.at(drawn.low_m), drawn.at(drawn.high_m));
      }
      if (wall.state != State::measured) continue;
      // As it was measured: off, and turned about its middle.
      const Vector middle = drawn.at((drawn.low_m + drawn.high_m) / 2);
      const Vector half = Eigen::Rotation2Dd(wall.turn_rad) * drawn.along() * drawn.length_m() / 2;
      const Vector off = drawn.normal * wall.off_m + wall.shift_m;
      svg.line(wall.is_off() ? "class=\"off\"" : "class=\"agrees\"", middle - half + off,
               middle + half + off);
    }
    if (wall.is_off() || wall.state == State::missing || wall.has_gap()) {
      const WallFace& some = wall.drawn[wall.drawn.size() / 2].face;
      svg.text(some.at((some.low_m + some.high_m) / 2) + 0.25 * some.normal,
               std::to_string(wall.number));
    }
  }
  for (const UndrawnWall& wall : deviations.undrawn) {
    svg.line(wall.furniture ? "class=\"furniture\"" : "class=\"more\"",
             wall.face.at(wall.face.low_m), wall.face.at(wall.face.high_m));
  }
  return svg.finish();
}

}  // namespace marco::plan
