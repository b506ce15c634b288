#include "drivers/textbase/report_counter.hpp"

#include <algorithm>
#include <cmath>

namespace marco::drivers::textbase {
namespace {

constexpr double kFastestMPerS = 10.0;

// Counters of 32 bits wrap.
int32_t difference(uint32_t now, uint32_t before) { return static_cast<int32_t>(now - before); }

}  // namespace

void ReportCounter::restart() {
  last_.reset();
  clock_.reset();
}

ReportCounter::Step ReportCounter::add(const Report& report, Utime left) {
  const Report before = last_.value_or(report);
  const int32_t since_ms = difference(report.board_ms, before.board_ms);
  if (since_ms < 0) return {.after_reset = true, .clicks = {}, .measured = {}};
  last_ = report;
  board_s_ += 1e-3 * since_ms;
  const int32_t left_ticks = difference(static_cast<uint32_t>(report.left_ticks),
                                        static_cast<uint32_t>(before.left_ticks));
  const int32_t right_ticks = difference(static_cast<uint32_t>(report.right_ticks),
                                         static_cast<uint32_t>(before.right_ticks));
  const double step_s = 1e-3 * std::max(since_ms, kLeastReportMs);
  const double most = kFastestMPerS * step_s / tick_m_;
  Step step;
  step.measured = clock_.update(board_s_, left);
  step.plausible = std::abs(static_cast<double>(left_ticks)) <= most &&
                   std::abs(static_cast<double>(right_ticks)) <= most;
  if (step.plausible) {
    step.clicks = {static_cast<double>(left_ticks), static_cast<double>(right_ticks),
                   left_ticks * tick_m_ / step_s, right_ticks * tick_m_ / step_s};
  }
  return step;
}

}  // namespace marco::drivers::textbase
