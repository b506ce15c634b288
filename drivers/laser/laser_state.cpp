#include "drivers/laser/laser_state.hpp"

#include "lcm_tools/base/format.hpp"

namespace marco::drivers {

std::string describe_scans(const LaserCounts& counts, const ClockFilter& filter) {
  return format("%lld scans, jitter %.2f ms, max %.2f ms", static_cast<long long>(counts.scans),
                filter.jitter_s() * 1e3, filter.max_delay_s() * 1e3);
}

std::string with_trouble(std::string state, const LaserCounts& counts, const std::string& trouble) {
  if (counts.garbage_bytes > 0) state += ", garbage bytes " + std::to_string(counts.garbage_bytes);
  if (!trouble.empty()) state += ", " + trouble;
  return state;
}

}  // namespace marco::drivers
