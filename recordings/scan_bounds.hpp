#pragma once

#include "common/samples.hpp"

namespace marco {

/// @throws std::invalid_argument where no laser turns out such a scan: fewer than two beams, more
/// than 100 000, or beams of equal steps that go round three times. Bearings of their own may come
/// in any order, as in clouds.
void require_scan(const LaserScan& scan);

}  // namespace marco
