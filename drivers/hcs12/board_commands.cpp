#include "drivers/hcs12/board_commands.hpp"

#include <algorithm>

namespace marco::drivers::hcs12 {

void BoardCommands::stop() {
  exchange_.clear_queue();
  exchange_.ask({encode_command('p'), 'p'});
  status();
}

void BoardCommands::ramp_if_new(const Ramp& wanted) {
  if (ramp_ != wanted) ramp(wanted);
}

void BoardCommands::ramp(const Ramp& wanted) {
  ramp_ = wanted;
  exchange_.ask({encode_command('k', {wanted.start, wanted.top, wanted.step_ticks}), 'k'});
}

void BoardCommands::run(const RunOrder& order) {
  exchange_.ask({encode_command(order.letter, {order.tenths}), order.letter});
}

void BoardCommands::wait_for_rest(const RampWalk& walk, Utime now) {
  constexpr double kSlowestPace = 1.25;  // of the board's ticks, as RunControl believes
  RampWalk rest = walk;
  rest.finish();
  const int64_t ticks = rest.ticks() - walk.ticks() + 600;
  const auto timer = static_cast<uint32_t>(std::min<int64_t>(ticks, 65000));
  // Four numbers: with the manual's three the firmware looks at no flags.
  exchange_.ask({encode_command('w', {timer, 1, 1, 0}), '\0'});
  wait_until_ = now + Duration::from_seconds(kSlowestPace * timer * kTickS + 1.0);
}

bool BoardCommands::give_up_wait(Utime now) {
  if (!wait_until_ || now < *wait_until_) return false;
  wait_until_.reset();
  ++lost_waits_;
  status();
  return true;
}

bool BoardCommands::poll(Utime now, double period_s) {
  if (now < next_status_ || !quiet()) return false;
  next_status_ = now + Duration::from_seconds(period_s);
  status();
  return true;
}

}  // namespace marco::drivers::hcs12
