#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "simulator/people.hpp"

namespace marco::sim {

enum class Material : uint8_t { plain, black, glass, mirror };

/// @param name plain, black, glass or mirror. @throws std::invalid_argument listing the known ones.
Material material_named(const std::string& name);

struct WallSize {
  double height_m = 2.6;
  double thickness_m = 0.12;
};

/// The geometry around the robot: triangles with a material each, and who walks there. World frame:
/// floor at z = 0, z up. The triangles alone are what stands there: what maps, models, cameras,
/// sonars and bumpers meet. The lasers see people too (laser_model.hpp).
struct World {
  std::vector<Eigen::Vector3f> vertices_m;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<Material> materials;  ///< one a triangle
  std::vector<Person> people;

  void add_quad(const std::array<Eigen::Vector3d, 4>& corners, Material material);
  /// An upright box with its six faces, turned by yaw about its centre.
  void add_box(const Eigen::Vector3d& centre,
               const Eigen::Vector3d& size,
               double yaw_rad,
               Material material);
  /// A round column standing on the floor, with its top. Its sides are flat, as many as keep its
  /// outline within 0.2 mm of the circle.
  void add_column(const Eigen::Vector2d& centre,
                  double radius_m,
                  double height_m,
                  Material material);
  /// A wall bent to an arc about `centre`, with both faces, its top and its two ends: as round as a
  /// column. @param radius_m  of its middle line. @param to_rad  counter-clockwise from `from_rad`
  void add_arc(const Eigen::Vector2d& centre,
               double radius_m,
               double from_rad,
               double to_rad,
               const WallSize& size,
               Material material);
};

/// A wall along a chain of corners: x1 y1 x2 y2 ...
struct WallSpec {
  std::vector<double> corners_m;
  double height_m = 2.6;
  double thickness_m = 0.12;
  std::string material = "plain";

  template <class Visitor>
  void visit(Visitor& v) {
    v("corners_m", corners_m);
    v("height_m", height_m, kPositive);
    v("thickness_m", thickness_m, kPositive);
    v("material", material);
  }
};

/// A wall bent to an arc; a whole circle from 0 to 360 degrees.
struct ArcSpec {
  std::vector<double> centre_m = {0, 0};
  double radius_m = 3.0;  ///< of its middle line
  double from_deg = 0.0;  ///< direction from the centre, 0 = along x
  double to_deg = 90.0;   ///< counter-clockwise from there, more than from_deg
  double height_m = 2.6;
  double thickness_m = 0.12;
  std::string material = "plain";

  template <class Visitor>
  void visit(Visitor& v) {
    v("centre_m", centre_m);
    v("radius_m", radius_m, Limits{0.01, 1000.0});
    v("from_deg", from_deg);
    v("to_deg", to_deg);
    v("height_m", height_m, kPositive);
    v("thickness_m", thickness_m, kPositive);
    v("material", material);
  }
};

struct BoxSpec {
  std::vector<double> at_m = {0, 0};       ///< centre on the floor plan
  std::vector<double> size_m = {1, 1, 1};  ///< along its own x, y, z
  double above_floor_m = 0.0;
  double yaw_deg = 0.0;
  std::string material = "plain";

  template <class Visitor>
  void visit(Visitor& v) {
    v("at_m", at_m);
    v("size_m", size_m, kPositive);
    v("above_floor_m", above_floor_m, kNotNegative);
    v("yaw_deg", yaw_deg);
    v("material", material);
  }
};

/// A top on four legs; with `back_m` above 0 a chair.
struct TableSpec {
  std::vector<double> at_m = {0, 0};
  std::vector<double> size_m = {1.4, 0.8};
  double height_m = 0.74;
  double back_m = 0.0;  ///< height of the back above the seat
  double yaw_deg = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("at_m", at_m);
    v("size_m", size_m, kPositive);
    v("height_m", height_m, kPositive);
    v("back_m", back_m, kNotNegative);
    v("yaw_deg", yaw_deg);
  }
};

/// A leaf on a hinge.
struct DoorSpec {
  std::vector<double> hinge_m = {0, 0};
  double width_m = 0.9;
  double height_m = 2.05;
  double closed_yaw_deg = 0.0;  ///< direction from the hinge when closed
  double open_deg = 0.0;        ///< counter-clockwise from there
  std::string material = "plain";

  template <class Visitor>
  void visit(Visitor& v) {
    v("hinge_m", hinge_m);
    v("width_m", width_m, kPositive);
    v("height_m", height_m, kPositive);
    v("closed_yaw_deg", closed_yaw_deg);
    v("open_deg", open_deg);
    v("material", material);
  }
};

struct ColumnSpec {
  std::vector<double> at_m = {0, 0};
  double radius_m = 0.2;
  double height_m = 2.6;

  template <class Visitor>
  void visit(Visitor& v) {
    v("at_m", at_m);
    v("radius_m", radius_m, Limits{0.001, 100.0});
    v("height_m", height_m, kPositive);
  }
};

/// Somebody who walks from waypoint to waypoint: around where the last is the first, otherwise to
/// and fro. Walks through whatever stands in the way, the robot too.
struct PersonSpec {
  std::vector<double> waypoints_m;  ///< x1 y1 x2 y2 ...
  double speed_m_per_s = 1.2;
  double ahead_s = 0.0;  ///< how long they have walked when a tour begins; sets people apart

  template <class Visitor>
  void visit(Visitor& v) {
    v("waypoints_m", waypoints_m);
    v("speed_m_per_s", speed_m_per_s, kNotNegative);
    v("ahead_s", ahead_s);
  }
};

/// A world file (config/worlds/*.toml).
struct WorldSpec {
  std::vector<double> floor_m = {0, 0, 10, 10};  ///< x0 y0 x1 y1 of floor and ceiling
  double ceiling_m = 2.6;
  std::vector<WallSpec> walls;
  std::vector<ArcSpec> arcs;
  std::vector<BoxSpec> boxes;
  std::vector<TableSpec> tables;
  std::vector<DoorSpec> doors;
  std::vector<ColumnSpec> columns;
  std::vector<PersonSpec> people;

  template <class Visitor>
  void visit(Visitor& v) {
    v("floor_m", floor_m);
    v("ceiling_m", ceiling_m, kPositive);
    v("walls", walls);
    v("arcs", arcs);
    v("boxes", boxes);
    v("tables", tables);
    v("doors", doors);
    v("columns", columns);
    v("people", people);
  }
};

/// @throws std::invalid_argument naming the element and what was expected.
World build_world(const WorldSpec& spec);

}  // namespace marco::sim
