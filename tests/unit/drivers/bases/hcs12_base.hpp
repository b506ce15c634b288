#pragma once

#include <algorithm>
#include <cmath>

#include "driven_base.hpp"
#include "drivers/hcs12/base_driver.hpp"
#include "simulator/devices/hcs12/base_emulator.hpp"

namespace marco::drivers::testing {

struct Hcs12Parts {
  Hcs12Parts(const hcs12::Hcs12BaseOptions& options, hcs12::BaseWorld world)
      : board(std::move(world), {}), driver(options) {}
  hcs12::BaseEmulator board;
  hcs12::Hcs12Base driver;
};

/// The emulated board of the HCS12 base and its driver.
struct Hcs12OnBench : Hcs12Parts, DrivenBase<hcs12::Hcs12Base> {
  explicit Hcs12OnBench(const hcs12::Hcs12BaseOptions& options = {}, hcs12::BaseWorld world = {})
      : Hcs12Parts(options, std::move(world)), DrivenBase(driver, board, 9600) {}

  void speed(double metres_per_s) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::set_speed;
    command.max_velocity_m_per_s = metres_per_s;
    command.max_yaw_rate_rad_per_s = metres_per_s / 0.25;
    order(command);
  }
  double clicks_off() const {
    return std::max(std::abs(board.left_clicks() - static_cast<double>(driver.left_clicks())),
                    std::abs(board.right_clicks() - static_cast<double>(driver.right_clicks())));
  }
};

}  // namespace marco::drivers::testing
