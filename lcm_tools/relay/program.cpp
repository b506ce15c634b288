#include "lcm_tools/relay/program.hpp"

#include <spdlog/spdlog.h>

#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcm_tools/relay/relay.hpp"

namespace marco::relay {
namespace {

constexpr const char* kHelp =
    R"(Joins LCM on this host (multicast) with other hosts over TCP, where multicast does not reach: Wi-Fi, VPN, cloud.

  robot:   marco-relay --listen 7700
  laptop:  ssh -N -L 7700:localhost:7700 robot &  marco-relay --connect 7700

Programs on both sides need no change. A program may also connect without a local relay, by LCM's url
tcpq://localhost:7700; it then ends with the connection, while a relay reconnects each second.
A link that is too slow loses the oldest messages of the channel that fills it, and counts them (PROCESS_STATUS).

Orders pass only with --orders: otherwise everybody who reaches the port could drive the robot or, by procman, start any
program, and over a bad link orders arrive late. Orders are BASE_COMMAND and the like, procman's, and channels with CMD,
COMMAND or ORDERS in their name. An EMERGENCY_STOP that engages always passes; a release is an order.

There are no passwords: listen on this host only (the default) and connect others through ssh or a VPN. Use
--listen 0.0.0.0:7700 only in a network whose members you all trust.)";

}  // namespace

int run_relay_program(int argc, char** argv, std::vector<std::string> order_channels) {
  return process::run_main("marco-relay", [&] {
    process::CommandLine app(kHelp, "marco-relay");
    RelayOptions options;
    options.order_channels = std::move(order_channels);
    std::string listen, lcm_url, log_level = "info";
    std::vector<std::string> connect;
    bool orders = false;
    app.add_option("--listen", listen, "[ADDRESS:]PORT for others to connect to");
    app.add_option("--connect", connect, "[HOST:]PORT of another relay; repeatable");
    app.add_option("--channels", options.channels,
                   "regular expression of the channels that pass, in both directions (all)");
    app.add_flag("--orders", orders, "also pass orders; needed on both sides");
    process::add_lcm_url(app, lcm_url);
    process::add_log_level(app, log_level);
    if (const auto code = app.parse(argc, argv)) return *code;
    process::require_usage(!listen.empty() || !connect.empty(), "give --listen or --connect");
    if (!listen.empty()) options.listen = parse_endpoint(listen);
    for (const std::string& one : connect) options.connect.push_back(parse_endpoint(one));
    if (orders) options.orders = ChannelRule::Orders::passed_on;
    process::start_logging("marco-relay", log_level);
    process::catch_stop_signals();
    process::DropCounter drops([](const std::string& text) { spdlog::warn(text); });
    process::LcmBus bus(lcm_url);
    process::StatusPublisher status(bus, "marco-relay", drops);
    Relay relay(bus, drops, std::move(options));
    spdlog::info("LCM at {}{}{}", process::effective_lcm_url(lcm_url),
                 listen.empty() ? "" : ", listening at " + to_string(parse_endpoint(listen)),
                 orders ? ", with orders" : ", without orders (--orders)");
    constexpr int kTimeoutMs = 200;
    while (!process::stop_requested()) {
      relay.run_once(kTimeoutMs);
      status.tick(relay.state());
    }
    spdlog::info("{}; {}", relay.state(), drops.summary());
    return process::kExitDone;
  });
}

}  // namespace marco::relay
