#pragma once

#include "common/samples.hpp"

namespace marco {

/// @throws std::invalid_argument where no laser turns out such a scan: fewer than two beams, more
/// than 100 000, or beams that go round three times.
void require_scan(const LaserScan& scan);

}  // namespace marco
