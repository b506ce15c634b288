#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <optional>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/progress.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcm_tools/process/version.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/map_request_t.hpp"
#include "recordings/recording.hpp"
#include "web/foxglove/json.hpp"
#include "web/page/page_files.hpp"
#include "web/process/page.hpp"
#include "web/process/page_arguments.hpp"
#include "web/process/recording.hpp"
#include "web/process/running_pages.hpp"
#include "web/process/token_file.hpp"
#include "web/snapshot/snapshot.hpp"
#include "web/steady_clock.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

constexpr int kWaitMs = 20;
constexpr int kMessagesAtOnce = 200;

using SpanNs = std::optional<std::pair<int64_t, int64_t>>;

foxglove::Identity identity(const char* mode, const std::string& name, SpanNs span_ns) {
  foxglove::Identity server{
      "marco-page " + name,
      std::to_string(process::wall_clock_us()) + "-" + std::to_string(getpid()),
      {"clientPublish", "services", "parameters"},
      {{"marco", process::version()}, {"mode", mode}, {"name", name}},
      span_ns};
  if (span_ns) server.capabilities.push_back("playbackControl");
  return server;
}

/// The server with what it serves.
struct Served {
  Served(const web::PageArguments& arguments,
         const char* mode,
         const std::string& name,
         SpanNs span_ns = {})
      : options(web::server_options(arguments)),
        token_file(web::token_file_of(arguments, options)),
        token(token_file.empty() ? "" : web::token_in(token_file)),
        access(web::access_of(arguments, options, token)),
        site(web::page_file, "/usr/share/javascript/three/three.min.js"),
        drops([](const std::string& line) { spdlog::warn("{}", line); }),
        hub(identity(mode, name, span_ns), drops, web::steady_s) {
    hub.add_parameter("mode", foxglove::text_json(mode));
    hub.add_parameter("marco", foxglove::text_json(process::version()));
  }

  /// From here on connections are taken.
  void open() {
    server = std::make_unique<web::Server>(options, access, site, hub, drops);
    try {
      entry = std::make_unique<web::PageEntry>(web::RunningPage{server->url(), token_file});
    } catch (const std::runtime_error& failure) {  // it is served all the same
      spdlog::warn("{}: --address will not list this page", failure.what());
    }
    const bool is_safe = web::is_seen_by_user_only();
    for (const auto& address : web::addresses_of(server->url(), is_safe ? token : "")) {
      std::printf("%s\n", address.c_str());
    }
    if (!token.empty() && !is_safe) {
      std::printf(
          "clients that open it can watch; to steer: marco page --address, on this host, as this "
          "user\n");
    }
    std::fflush(stdout);
  }

  std::string state() const {
    return std::to_string(hub.clients()) + " clients; " + std::to_string(hub.dropped()) +
           " messages dropped for lack of space";
  }

  web::ServerOptions options;
  std::string token_file, token;
  web::Access access;
  web::Site site;
  process::DropCounter drops;
  web::Hub hub;
  std::unique_ptr<web::Server> server;
  std::unique_ptr<web::PageEntry> entry;
};

int show_live(const web::PageArguments& arguments, const web::SteeringOptions& steering) {
  const std::string url = process::effective_lcm_url(arguments.common.lcm_url);
  Served served(arguments, "live", url);
  process::LcmBus bus(arguments.common.lcm_url);
  process::StatusPublisher status(bus, "marco-page", served.drops);
  web::Page page(served.hub, {bus, served.drops, &bus, arguments.common.lcm_url}, steering);
  served.open();
  map_request_t request;
  request.utime = process::wall_clock_us();
  bus.publish(channels::kMapRequest, request);  // what is known so far
  while (!process::stop_requested()) {
    served.server->step(bus.lcm().getFileno(), bus.waiting() ? 0 : kWaitMs);
    for (int n = 0; n < kMessagesAtOnce && bus.handle_once(0); ++n) {
      // What comes in a burst is sent message by message, and orders have their turn.
      served.server->step(-1, 0);
    }
    page.step(Utime::from_us(process::wall_clock_us()));
    status.tick(page.state(served.state()));
  }
  spdlog::info("{}; {}", served.state(), served.drops.summary());
  return 0;
}

int show_recording(const web::PageArguments& arguments, const web::SteeringOptions& steering) {
  std::optional<process::Progress> reading;
  reading.emplace("reading " + std::filesystem::path(arguments.shown).filename().string()).show();
  web::Recording recording(arguments.shown, arguments.speed);
  reading.reset();
  Served served(arguments, "recording", std::filesystem::path(arguments.shown).filename().string(),
                std::pair{recording.span().first.us * 1000, recording.span().last.us * 1000});
  web::Page page(served.hub, {recording.bus(), served.drops, nullptr, ""}, steering);
  recording.serve(served.hub);
  served.open();
  int wait_ms = 0;
  while (!process::stop_requested()) {
    served.server->step(-1, wait_ms);
    wait_ms = recording.advance(procman::monotonic_us());
    page.step(recording.position());
  }
  return 0;
}

int show_folder(const web::PageArguments& arguments) {
  Served served(arguments, "folder", std::filesystem::path(arguments.shown).filename().string());
  served.site.show_folder(arguments.shown, web::snapshot_json(arguments.shown));
  served.open();
  while (!process::stop_requested()) served.server->step(-1, 200);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-page", [&] {
    process::CommandLine app(
        "Serves a page for the browser: the growing map, the robot, its programs and controls; "
        "also a map folder or a recording. Foxglove's app connects to the same "
        "address (ws://127.0.0.1:8765).");
    web::PageArguments arguments;
    web::add_page_arguments(app, arguments);
    if (const auto code = app.parse(argc, argv)) return *code;
    if (arguments.wants_address) return web::print_addresses();
    const auto steering = process::load_options<web::SteeringOptions>(arguments.common.config_path);
    if (process::prints_config(arguments.common, steering)) return 0;
    process::start_logging("marco-page", arguments.common.log_level);
    process::catch_stop_signals();
    if (arguments.shown.empty()) return show_live(arguments, steering);
    require(std::filesystem::exists(arguments.shown), arguments.shown + ": there is no such file");
    // A map's folder holds its results; a folder may be a recording as well.
    const bool is_map =
        std::filesystem::exists(std::filesystem::path(arguments.shown) / "map.yaml");
    const bool is_recording = !is_map && marco::is_recording(arguments.shown);
    return is_recording ? show_recording(arguments, steering) : show_folder(arguments);
  });
}
