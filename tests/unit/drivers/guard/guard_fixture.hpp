#pragma once

#include <gtest/gtest.h>

#include <optional>

#include "guard_bench.hpp"

namespace marco::drivers::testing {

/// A base in a world that a test puts up; the guard's defaults.
class Guard : public ::testing::Test {
 protected:
  using Fate = BaseStatus::Command;
  using Kind = BaseCommand::Kind;
  void begin(const Pose2& at = {}) {
    bench_.emplace(world_, options_, random_);
    bench_->laser = laser_;
    bench_->start(at);
  }
  void begin_seeing(const Pose2& at = {}) {
    begin(at);
    bench_->run(0.5);
  }
  BaseCommand leg(Kind kind, double amount) {
    BaseCommand command;
    command.kind = kind;
    command.distance_m = command.angle_rad = amount;
    return command;
  }
  /// @returns the fate of a leg.
  Fate drive(Kind kind, double amount) {
    bench_->give(leg(kind, amount));
    for (int i = 0; i < 3000 && bench_->base().status().command == Fate::running; ++i)
      bench_->run(0.02);
    return bench_->base().status().command;
  }
  Fate move(double distance_m) { return drive(Kind::move, distance_m); }
  const Pose2& pose() { return bench_->base().world_from_robot; }
  double gap_m() { return world_.gap(bench_->body(), pose()).gap_m; }
  double speed() { return bench_->base().velocity().ahead_m_per_s; }

  GuardWorld world_;
  GuardOptions options_;
  BenchLaser laser_;
  std::mt19937 random_{5};
  std::optional<GuardBench> bench_;
};

}  // namespace marco::drivers::testing
