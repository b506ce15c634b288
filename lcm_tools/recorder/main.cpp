#include <spdlog/spdlog.h>

#include <cstdlib>
#include <thread>

#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcm_tools/recorder/recorder.hpp"

namespace {

constexpr const char* kHelp =
    R"(Records all channels with lcm-logger: each start makes a folder in FOLDER, named by its time, with pieces of 500 MB
(MARCO_RECORD_MB). Keeps a tenth of the disk free, at most 5 GB: it deletes the oldest recordings and reports this, but never
one that was kept (marco-log keep), renamed or put there by others. If none may be deleted, recording waits for space.)";

std::string piece_mb() {
  const char* given = std::getenv("MARCO_RECORD_MB");
  const std::string text = given == nullptr || *given == '\0' ? "500" : given;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  marco::require(*end == '\0' && value > 0.0, "MARCO_RECORD_MB=" + text + " is not a size in MB");
  return text;
}

}  // namespace

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

int main(int argc, char** argv) {
  return process::run_main("marco-recorder", [&] {
    process::CommandLine app(kHelp, "marco-recorder");
    std::string folder, lcm_url, log_level = "info";
    app.add_option("FOLDER", folder, "of the recordings").required();
    process::add_lcm_url(app, lcm_url);
    process::add_log_level(app, log_level);
    if (const auto code = app.parse(argc, argv)) return *code;
    process::start_logging("marco-recorder", log_level);
    process::catch_stop_signals();
    process::DropCounter drops;
    process::LcmBus bus(lcm_url);
    bus.keep_going_without_network();
    process::StatusPublisher status(bus, "marco-recorder", drops);
    recorder::Recorder recorder({folder, bus.url(), piece_mb()},
                                [](const std::string& line) { spdlog::info(line); });
    constexpr std::chrono::milliseconds kStep{100};
    constexpr std::chrono::minutes kSayEvery{10};
    auto say_at = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!process::stop_requested()) {
      const auto now = std::chrono::steady_clock::now();
      recorder.step(now);
      status.tick(recorder.state());
      if (now >= say_at) {
        spdlog::info(recorder.state());
        say_at = now + kSayEvery;
      }
      std::this_thread::sleep_for(kStep);
    }
    recorder.stop(recorder::LoggerChild::Told::already);
    spdlog::info("ended; {}", recorder.state());
    return process::kExitDone;
  });
}
