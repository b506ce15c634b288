// The tour of the simulated office: how often the guard stops a robot that would touch nothing.
#include <gtest/gtest.h>

#include "guard_bench.hpp"
#include "lcm_tools/process/config.hpp"
#include "simulator/tour.hpp"
#include "simulator/world.hpp"

namespace marco::drivers {
namespace {

using testing::GuardBench;
using testing::GuardWorld;
using Fate = BaseStatus::Command;

/// What of a world is at the height of the laser's plane.
GuardWorld slice(const sim::World& world, double height_m) {
  GuardWorld floor;
  for (const auto& triangle : world.triangles) {
    std::vector<Eigen::Vector2d> cuts;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d a = world.vertices_m[triangle[i]].cast<double>(),
                            b = world.vertices_m[triangle[(i + 1) % 3]].cast<double>();
      if ((a.z() < height_m) == (b.z() < height_m)) continue;
      const double part = (height_m - a.z()) / (b.z() - a.z());
      cuts.emplace_back((a + part * (b - a)).head<2>());
    }
    if (cuts.size() == 2 && cuts[0] != cuts[1]) floor.things.push_back({cuts[0], cuts[1], 0.0});
  }
  return floor;
}

struct Office {
  GuardWorld world = slice(
      sim::build_world(process::load_options<sim::WorldSpec>("config/worlds/office.toml")), 0.3);
  sim::Tour tour = process::load_options<sim::Tour>("config/tours/office.toml");
  std::mt19937 random{9};
  GuardBench bench{world, {}, random};
  double way_m = 0.0;
  int stops = 0;
  Eigen::Vector2d stopped_at_m{-10.0, -10.0};

  explicit Office(double view_deg) {
    bench.laser.view_deg = view_deg;
    bench.laser.beams = 121;
    bench.laser.noise_m = 0.01;
    bench.start({tour.start_m[0], tour.start_m[1], deg_to_rad(tour.start_heading_deg)});
    bench.run(0.5);
  }
  Eigen::Vector2d to(const Eigen::Vector2d& goal_m) {
    return bench.base().world_from_robot.inverse() * goal_m;
  }
  /// What is left of an order may be a turn that nobody sees.
  bool stands() const { return bench.base().velocity().fastest_m_per_s(0.4) < 0.01; }
  /// Within a metre of the last one it is the same, taken up too early.
  void note_stop() {
    if (to(stopped_at_m).norm() < 1.0) return;
    stopped_at_m = bench.base().world_from_robot.translation_m();
    ++stops;
  }
  /// Turns away from what is nearest, and drives past it.
  void steer_around() {
    const Eigen::Vector2d at_m = bench.world().gap(bench.body(), bench.base().world_from_robot).at;
    const double away = to(at_m).y() > 0.0 ? -1.0 : 1.0;
    bench.run(1.0, BaseVelocity{0.0, 0.3 * away});
    bench.run(2.5, BaseVelocity{0.2, 0.0});
  }
  /// Drives to each place of the tour. @param go  @returns the stops on one's way.
  template <class Go>
  void drive(Go go) {
    for (const sim::TourStep& step : tour.steps) {
      if (step.kind != "go") continue;
      const Eigen::Vector2d goal_m(step.to_m[0], step.to_m[1]);
      way_m += to(goal_m).norm();
      const int before = stops;
      go(goal_m);
      if (stops > before) {
        std::printf("towards %.1f %.1f: %s\n", goal_m.x(), goal_m.y(), bench.note().c_str());
      }
    }
    std::printf("%.0f m, %d stops\n", way_m, stops);
    std::fflush(stdout);
    EXPECT_GT(way_m, 150.0);
    EXPECT_FALSE(bench.touched());
  }
};

class GuardInTheOffice : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Views, GuardInTheOffice, ::testing::Values(180.0, 360.0));

TEST_P(GuardInTheOffice, LegsAreNotStopped) {
  Office office(GetParam());
  office.drive([&](const Eigen::Vector2d& goal_m) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::go_to;
    command.point_m = goal_m;
    office.bench.give(command);
    const auto fate = [&] { return office.bench.base().status().command; };
    for (int i = 0; i < 6000 && fate() == Fate::running; ++i) office.bench.run(0.02);
    office.stops += fate() == Fate::done ? 0 : 1;
  });
  EXPECT_LE(office.stops, office.way_m / 100.0);
}

// As somebody drives by a stick: ahead, and turning towards the place meanwhile. Where the robot is
// stopped he steers around what is there, as the leaf of a door that it would pass at 4 cm.
TEST_P(GuardInTheOffice, VelocitiesAreNotStopped) {
  Office office(GetParam());
  office.drive([&](const Eigen::Vector2d& goal_m) {
    bool stands = true;  // at a place it may
    int blocked = 0;
    for (int i = 0; i < 6000 && office.to(goal_m).norm() > 0.15; ++i) {
      const Eigen::Vector2d way = office.to(goal_m);
      const double bearing = std::atan2(way.y(), way.x());
      const double speed = std::abs(bearing) < 0.5 ? std::min(0.5, 0.2 + way.norm() / 2.0) : 0.0;
      office.bench.run(0.02, BaseVelocity{speed, std::clamp(1.5 * bearing, -0.8, 0.8)});
      const bool stood = std::exchange(stands, office.stands());
      if (stands && !stood) office.note_stop();
      if (stands && speed > 0.0 && ++blocked > 50) {
        office.steer_around();
        blocked = 0;
      }
    }
    EXPECT_LE(office.to(goal_m).norm(), 0.15) << goal_m.transpose();
  });
  EXPECT_LE(office.stops, office.way_m / 100.0);
}

}  // namespace
}  // namespace marco::drivers
