#include "plan/sheet/plan_export.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace marco::plan {
namespace {

using Json = nlohmann::ordered_json;

double rounded(double value) { return std::round(value * 1e4) / 1e4; }
Json at(const Eigen::Vector2d& point) { return {rounded(point.x()), rounded(point.y())}; }

Json feature(const char* kind, const char* shape, Json coordinates) {
  Json entry;
  entry["type"] = "Feature";
  entry["geometry"] = {{"type", shape}, {"coordinates", std::move(coordinates)}};
  entry["properties"] = {{"kind", kind}};
  return entry;
}

Json room_feature(const PlanRoom& room) {
  Json rings = Json::array();
  for (const auto& loop : room.loops) {
    Json ring = Json::array();
    for (const RoomEdge& edge : loop) {
      for (const auto& point : bulge_points(edge.from, edge.to, edge.bulge)) {
        ring.push_back(at(point));
      }
    }
    if (!ring.empty()) ring.push_back(ring.front());
    rings.push_back(std::move(ring));
  }
  Json entry = feature("room", "Polygon", std::move(rings));
  Json edges = Json::array();
  for (const RoomEdge& edge : room.edges()) {
    const char* kind = edge.kind == EdgeKind::wall      ? "wall"
                       : edge.kind == EdgeKind::opening ? "opening"
                                                        : "not seen";
    // One a side of the ring.
    const std::size_t sides = bulge_points(edge.from, edge.to, edge.bulge).size();
    for (std::size_t i = 0; i < sides; ++i) edges.push_back(kind);
  }
  entry["properties"].update({{"name", room.name},
                              {"area_m2", rounded(room.area_m2)},
                              {"area_sigma_m2", rounded(room.area_sigma_m2)},
                              {"perimeter_m", rounded(room.perimeter_m)},
                              {"clear_size_m", at(room.size_m)},
                              {"label_at_m", at(room.label_at)},
                              {"seen", rounded(room.seen)},
                              {"edges", edges}});
  return entry;
}

Json chain(const std::vector<Eigen::Vector2d>& points) {
  Json line = Json::array();
  for (const Eigen::Vector2d& point : points) line.push_back(at(point));
  return line;
}

Json wall_feature(const PlanWall& wall) {
  std::vector<Eigen::Vector2d> points = bulge_points(wall.from, wall.to, wall.bulge);
  points.push_back(wall.to);
  Json entry = feature("wall", "LineString", chain(points));
  entry["properties"].update({{"thickness_m", rounded(wall.thickness_m)},
                              {"thickness_assumed", wall.assumed},
                              {"seen_from", at(wall.normal)}});
  return entry;
}

Json arc_feature(const RoundWall& arc) {
  Json entry = feature("curved face", "LineString", chain(outline_of(arc)));
  entry["properties"].update({{"centre_m", at(arc.centre_m)},
                              {"radius_m", rounded(arc.radius_m)},
                              {"radius_sigma_m", rounded(std::sqrt(arc.covariance(2, 2)))},
                              {"from_deg", rounded(rad_to_deg(arc.from_rad))},
                              {"span_deg", rounded(rad_to_deg(arc.span_rad))},
                              {"seen_from_inside", arc.from_inside},
                              {"circle", arc.id}});
  return entry;
}

Json opening_feature(const PlanOpening& opening, double scale_sigma) {
  Json entry = feature("opening", "LineString", Json::array({at(opening.from), at(opening.to)}));
  entry["properties"].update(
      {{"door", opening.is_door()},
       {"width_m", rounded(opening.width_m())},
       {"width_sigma_m", rounded(std::hypot(opening.sigma_m, scale_sigma * opening.width_m()))},
       {"wall_thickness_m", rounded(opening.depth_m)}});
  if (opening.has_leaf) {
    entry["properties"]["leaf_m"] = Json::array({at(opening.hinge), at(opening.leaf_end)});
  }
  return entry;
}

Json object_feature(const PlanObject& object) {
  if (object.round) {
    Json entry = feature("column", "Point", at(object.centre));
    entry["properties"]["radius_m"] = rounded(object.radius_m);
    if (object.radius_sigma_m > 0.0) {
      entry["properties"]["radius_sigma_m"] = rounded(object.radius_sigma_m);
    }
    return entry;
  }
  Json ring = Json::array();
  for (const Eigen::Vector2d& point : object.outline) ring.push_back(at(point));
  ring.push_back(ring.front());
  return feature("furniture", "Polygon", Json::array({ring}));
}

}  // namespace

std::string plan_json(const FloorPlan& plan) {
  Json root;
  root["type"] = "FeatureCollection";
  root["crs"] = "local, metres; x to the right and y up on the sheet";
  root["map_from_plan"] = {{"x_m", plan.map_from_plan.x_m},
                           {"y_m", plan.map_from_plan.y_m},
                           {"theta_rad", plan.map_from_plan.theta_rad}};
  root["scale_sigma"] = plan.scale_sigma;
  Json features = Json::array();
  for (const PlanRoom& room : plan.rooms) features.push_back(room_feature(room));
  for (const PlanWall& wall : plan.walls) {
    features.push_back(wall_feature(wall));
  }
  for (const RoundWall& arc : plan.arcs) features.push_back(arc_feature(arc));
  for (const PlanOpening& opening : plan.openings)
    features.push_back(opening_feature(opening, plan.scale_sigma));
  for (const PlanObject& object : plan.objects) features.push_back(object_feature(object));
  root["features"] = features;
  return root.dump(1) + "\n";
}

}  // namespace marco::plan
