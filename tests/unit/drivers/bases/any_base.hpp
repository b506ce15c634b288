#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "driven_base.hpp"
#include "drivers/create/driver.hpp"
#include "drivers/kobuki/driver.hpp"
#include "drivers/p2os/driver.hpp"
#include "hcs12_base.hpp"
#include "simulator/devices/create/emulator.hpp"
#include "simulator/devices/kobuki/emulator.hpp"
#include "simulator/devices/p2os/emulator.hpp"
#include "simulator/devices/textbase/emulator.hpp"
#include "text_base.hpp"

/// Every base with its emulated robot, each on a bench of its own: what all do alike is one test.
namespace marco::drivers::testing {

struct PioneerParts {
  PioneerParts(const p2os::P2osOptions& options, const p2os::P2osEmulatorOptions& robot_options)
      : robot({}, robot_options), driver(options) {}
  p2os::P2osEmulator robot;
  p2os::P2osBase driver;
};

struct Pioneer : PioneerParts, DrivenBase<p2os::P2osBase> {
  explicit Pioneer(const p2os::P2osEmulatorOptions& robot_options = {})
      : PioneerParts({}, robot_options), DrivenBase(driver, robot, p2os::kBaud) {}
  bool moves() const {
    return robot.velocity_m_per_s() != 0.0 || robot.yaw_rate_rad_per_s() != 0.0;
  }
  double way_m() const { return robot.left_m(); }
};

struct Hcs12 : Hcs12OnBench {
  bool moves() const { return board.motors_on(); }
  double way_m() const { return board.left_clicks() * std::numbers::pi * 0.3 / 65500.0; }
};

struct HomeMadeParts {
  textbase::TextBoard robot;
  textbase::TextBase driver{textbase::small_robot()};
};

struct HomeMade : HomeMadeParts, DrivenBase<textbase::TextBase> {
  HomeMade() : DrivenBase(driver, robot, textbase::kBaud) {}
  bool moves() const {  // its wheels creep to a stand: 3 mm/s
    return std::abs(robot.left_ticks_per_s()) > 20.0 || std::abs(robot.right_ticks_per_s()) > 20.0;
  }
  double way_m() const { return robot.left_ticks() / ticks_per_m(textbase::small_robot()); }
};

struct CreateParts {
  create::CreateEmulator robot;
  create::CreateBase driver{create::CreateOptions{}};
};

struct Create : CreateParts, DrivenBase<create::CreateBase> {
  Create() : DrivenBase(driver, robot, create::kBaud) {}
  bool moves() const {  // its wheels creep to a stand
    return std::abs(robot.left_m_per_s()) > 0.003 || std::abs(robot.right_m_per_s()) > 0.003;
  }
  double way_m() const { return robot.left_m(); }
};

struct KobukiParts {
  kobuki::KobukiEmulator robot;
  kobuki::KobukiBase driver{kobuki::KobukiOptions{}};
};

struct Kobuki : KobukiParts, DrivenBase<kobuki::KobukiBase> {
  Kobuki() : DrivenBase(driver, robot, kobuki::kBaud) {}
  bool moves() const {  // its wheels creep to a stand
    return std::abs(robot.left_m_per_s()) > 0.003 || std::abs(robot.right_m_per_s()) > 0.003;
  }
  double way_m() const { return robot.left_m(); }
};

using Bases = ::testing::Types<Hcs12, Pioneer, HomeMade, Create, Kobuki>;

}  // namespace marco::drivers::testing
