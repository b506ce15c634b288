#include "common/order_age.hpp"

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco {
namespace {

std::string in_words(double seconds) {
  constexpr double kDayS = 86400.0, kMuchS = 1000.0;  // how it is told, only
  if (seconds >= kDayS) return format("%.0f days", seconds / kDayS);
  return format(seconds < kMuchS ? "%.1f s" : "%.0f s", seconds);
}

}  // namespace

std::string why_stale(Utime given, Utime now) {
  const double age_s = (now - given).seconds();
  const std::string hint =
      "; unless it comes from a recording, synchronize both computers' clocks (NTP)";
  if (age_s > kOrderHoldsS) {
    return "order is " + in_words(age_s) + " old by this computer's clock" + hint;
  }
  if (age_s < -kOrderHoldsS) {
    return "order is stamped " + in_words(-age_s) + " ahead of this computer's clock" + hint;
  }
  return "";
}

void require_fresh(const char* type, Utime given, Utime now) {
  require(why_stale(given, now).empty(),
          std::string(type) + ": too old, or stamped ahead of this computer's clock");
}

void require_fresh(const PanTiltCommand& command, Utime now) {
  if (command.kind != PanTiltCommand::Kind::stop) {
    require_fresh("pantilt_command_t", command.utime, now);
  }
}

}  // namespace marco
