#include <cstdio>
#include <optional>
#include <utility>

#include "common/pose2.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/base/format.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "teleop/head_move.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using drivers::wall_now;
using Next = teleop::HeadMove::Next;

constexpr double kAnswerS = 3.0;  ///< a pan-tilt says ten times a second where it looks

void send(process::LcmBus& bus, PanTiltCommand command) {
  command.utime = wall_now();
  bus.publish(channels::kPanTiltCommand, to_message(command));
}

std::string angles(const PanTiltState& state) {
  return format("pan %.1f, tilt %.1f degrees", rad_to_deg(state.pan_rad),
                rad_to_deg(state.tilt_rad));
}

int fail(const std::string& why) {
  print(stderr, "marco head: %s\n", why.c_str());
  return process::kExitFailed;
}

int turn(process::LcmBus& bus, const PanTiltCommand& target) {
  process::DropCounter drops;
  std::optional<PanTiltState> heard;
  bus.subscribe<pantilt_state_t>(
      channels::kPanTiltState, drops,
      [&heard](const auto& message, const auto&) { heard = from_message(message); });
  send(bus, target);
  teleop::HeadMove move(target);
  Utime last = wall_now();
  while (!process::stop_requested()) {
    bus.handle_once(50);
    const auto state = std::exchange(heard, std::nullopt);
    if (!state) {
      if ((wall_now() - last).seconds() < kAnswerS) continue;
      return fail("no pan-tilt reports its angles. Is its driver running, on this network?");
    }
    last = wall_now();
    switch (move.on_state(*state)) {
      case Next::wait:
        break;
      case Next::there:
        print(stdout, "there: %s\n", angles(*state).c_str());
        return process::kExitDone;
      case Next::ended:
        return fail("it stands at " + angles(*state) +
                    ": it cannot reach farther, or obeys another order");
    }
  }
  send(bus, {});  // a stop
  fail("stopped");
  return process::kExitSignal + process::stopped_by();
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-head", [&] {
    process::CommandLine app(
        "Points the pan-tilt, and waits until it stands. Angles are in degrees. 0 0 is straight "
        "ahead and level, as mapping requires. Ctrl-C stops it.");
    std::string lcm_url;
    double pan_deg = 0.0, tilt_deg = 0.0;
    app.add_option("PAN", pan_deg, "[degrees] to the left of ahead")
        .required()
        .between(-360.0, 360.0);
    app.add_option("TILT", tilt_deg, "[degrees] up from level").required().between(-180.0, 180.0);
    process::add_lcm_url(app, lcm_url);
    if (const auto code = app.parse(argc, argv)) return *code;
    process::catch_stop_signals();
    process::LcmBus bus(lcm_url);
    PanTiltCommand target;
    target.kind = PanTiltCommand::Kind::go_to;
    target.pan_rad = deg_to_rad(pan_deg);
    target.tilt_rad = deg_to_rad(tilt_deg);
    return turn(bus, target);
  });
}
