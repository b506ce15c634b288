#include <cstdio>

#include "common/files/event_log.hpp"
#include "common/process/arguments.hpp"
#include "common/process/config.hpp"
#include "common/process/progress.hpp"
#include "drivers/simulator/batch_simulation.hpp"
#include "lcmtypes/convert.hpp"

namespace marco {
namespace {

struct Arguments {
  std::string world;
  std::string tour;
  std::string preset = "default";
  std::string config;
  std::string out;
  uint64_t seed = 1;
};

sim::SimulationOptions options_of(const Arguments& arguments) {
  sim::SimulationOptions options =
      arguments.preset == "harsh" ? sim::harsh_options() : sim::SimulationOptions{};
  if (!arguments.config.empty()) {
    process::read_options(process::read_toml(arguments.config), options, arguments.config);
  }
  return options;
}

int run(const Arguments& arguments) {
  const sim::World world = sim::build_world(process::load_options<sim::WorldSpec>(arguments.world));
  const sim::RayCaster rays(world);
  sim::BatchSimulation simulation(rays, process::load_options<sim::Tour>(arguments.tour),
                                  options_of(arguments), arguments.seed);
  files::EventLogWriter log(arguments.out);
  process::Progress progress("simulating");
  simulation.run(
      [&log](const Sample& sample, Utime sent) {
        const EncodedMessage message = encode_sample(sample);
        log.write(message.channel, message.bytes, sent);
      },
      [&progress](double part) { progress.update(part); });
  log.flush();
  std::printf("%.0f s simulated, %lld messages in %s\n", simulation.duration_s(),
              static_cast<long long>(log.events_written()), arguments.out.c_str());
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco-simulate", [&] {
    CLI::App app(
        "Drives a simulated robot through a world and writes an LCM log of what it senses");
    marco::Arguments arguments;
    bool print_config = false;
    app.add_option("--world", arguments.world, "e.g. config/worlds/lab.toml")
        ->check(CLI::ExistingFile);
    app.add_option("--tour", arguments.tour, "e.g. config/tours/lab.toml")
        ->check(CLI::ExistingFile);
    app.add_option("--seed", arguments.seed)->capture_default_str();
    app.add_option("--preset", arguments.preset, "default, or harsh as real logs are")
        ->check(CLI::IsMember({"default", "harsh"}))
        ->capture_default_str();
    app.add_option("--config", arguments.config, "TOML over the preset; unknown keys are refused")
        ->check(CLI::ExistingFile);
    app.add_option("--out", arguments.out, "the log to write");
    app.add_flag("--print-config", print_config, "print the config in force and exit");
    if (const auto code = marco::process::parse_arguments(app, argc, argv)) return *code;
    if (print_config) {
      std::fputs(marco::process::print_options(marco::options_of(arguments)).c_str(), stdout);
      return 0;
    }
    marco::require(!arguments.world.empty() && !arguments.tour.empty() && !arguments.out.empty(),
                   "give --world, --tour and --out");
    return marco::run(arguments);
  });
}
