#pragma once

#include <string>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/lcm_bus.hpp"

namespace marco::web {

/// Where messages come from, and where orders go.
struct Source {
  process::Bus& in;
  process::DropCounter& drops;      ///< counts what is left out
  process::LcmBus* live = nullptr;  ///< null: a recording; nothing is sent
  std::string lcm_url;
};

}  // namespace marco::web
