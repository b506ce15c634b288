#include <cstdio>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/procman/output_log.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/message_check.hpp"
#include "lcm_tools/procman/process/messages.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"

namespace {

using namespace marco;           // NOLINT(google-build-using-namespace): a main has no other names
using namespace marco::procman;  // NOLINT(google-build-using-namespace)

// Deputies and sheriffs speak once a second.
constexpr int64_t kListenUs = 1'300'000;
// Beyond what a command may be given to end.
constexpr int64_t kPatienceUs = 20'000'000;

/// Listens to deputies and their sheriff, and sends one order.
class Guest {
 public:
  explicit Guest(const std::string& lcm_url)
      : bus_(lcm_url),
        state_(kGuest + ("marco-procman-order:" + std::to_string(process::wall_clock_us())), true) {
    subscribe_checked<procman_lcm::deputy_info_t>(
        bus_, procman::channels::kInfo, layouts::kInfo, drops_, [this](const auto& message) {
          state_.on_info(from_message(message), process::wall_clock_us(), monotonic_us());
        });
    subscribe_checked<procman_lcm::orders_t>(bus_, procman::channels::kOrders, layouts::kOrders,
                                             drops_, [this](const auto& message) {
                                               // What its sheriff wants meanwhile is not what was
                                               // ordered here: the deputy's word counts.
                                               if (!has_ordered_)
                                                 state_.on_orders(from_message(message));
                                             });
    bus_.publish(procman::channels::kDiscover, discovery_message(state_.id(), 0));
    const int64_t end_us = monotonic_us() + kListenUs;
    while (monotonic_us() < end_us && !process::stop_requested()) bus_.handle_once(50);
    require(!state_.deputies().empty(),
            "no procman deputy answers. Is one running, on this network?");
  }

  int list() const {
    for (const auto& [id, command] : state_.commands()) {
      std::printf("%-24s %-16s %s\n", printable(id).c_str(), status_text(command.status()),
                  printable(command.deputy).c_str());
    }
    return process::kExitDone;
  }

  int give(const std::string& action, const std::string& id) {
    const Orders orders = state_.single_order(id, action, process::wall_clock_us(), monotonic_us());
    has_ordered_ = true;
    bus_.publish(procman::channels::kOrders, procman::to_message(orders));
    const int64_t end_us = monotonic_us() + kPatienceUs;
    const SheriffCommand& command = state_.commands().at(id);
    while (!command.settled() && monotonic_us() < end_us && !process::stop_requested()) {
      bus_.handle_once(50);
    }
    const Status now = command.status();
    const bool done = action == "stop" ? now == Status::stopped_ok || now == Status::stopped_error
                                       : now == Status::running || now == Status::stopped_ok;
    std::fprintf(done ? stdout : stderr, "%s: %s\n", id.c_str(), status_text(now));
    return done ? process::kExitDone : process::kExitFailed;
  }

 private:
  process::LcmBus bus_;
  process::DropCounter drops_;
  SheriffState state_;
  bool has_ordered_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-procman-order", [&] {
    process::CommandLine app(
        "Starts, stops or restarts one command of the running procman, next to its sheriff, and "
        "reports the result.");
    std::string lcm_url, name, action;
    process::add_lcm_url(app, lcm_url);
    app.require_subcommand();
    app.add_subcommand("list", "all commands: name, state, deputy");
    for (const char* word : {"start", "stop", "restart"}) {
      app.add_subcommand(word, std::string(word) + " the command NAME",
                         [&action, word] { action = word; })
          .add_option("NAME", name, "as list prints it")
          .required();
    }
    if (const auto code = app.parse(argc, argv)) return *code;
    process::catch_stop_signals();
    Guest guest(lcm_url);
    return action.empty() ? guest.list() : guest.give(action, name);
  });
}
