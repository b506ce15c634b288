#pragma once

#include <string>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/transport/clock_filter.hpp"

namespace marco::drivers {

/// "312 scans, jitter 0.20 ms, max 1.31 ms": how well the stamps of a laser are known.
std::string describe_scans(const LaserCounts& counts, const ClockFilter& filter);

/// `state` with ", garbage bytes 12" and ", <trouble>" behind it, where there are any.
std::string with_trouble(std::string state, const LaserCounts& counts, const std::string& trouble);

}  // namespace marco::drivers
