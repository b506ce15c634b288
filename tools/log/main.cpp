#include <cstdio>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/log/extensions.hpp"
#include "lcm_tools/log/late_progress.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "recordings/import_recording.hpp"
#include "recordings/lcm_log_reader.hpp"
#include "recordings/recording.hpp"
#include "tools/log/convert.hpp"
#include "tools/log/describe_recording.hpp"
#include "tools/log/export_carmen.hpp"
#include "tools/log/foxglove.hpp"

namespace marco::logs {
namespace {

void print_count(int64_t count, const char* what) {
  if (count > 0) print(stdout, "  %lld %s\n", static_cast<long long>(count), what);
}

void write_carmen(const ExportArguments& arguments, const std::string& foreign_table) {
  require(arguments.channels.empty() && arguments.from.empty() && arguments.to.empty(),
          "carmen: choose channels and times with `filter` and `cut` first");
  const auto recording =
      open_lcm_log(arguments.in, process::load_options<ForeignTable>(foreign_table));
  const std::string truth_path =
      std::filesystem::path(arguments.out).replace_extension(".truth").string();
  OutputFile out(arguments.out, arguments.existing, {arguments.in});
  OutputFile truth(truth_path, arguments.existing, {arguments.in, arguments.out});
  CarmenResult result;
  {
    LateProgress progress("writing " + arguments.out);
    result = export_carmen(*recording, out, &truth, progress.callback());
  }
  out.finish();
  if (result.true_poses > 0) truth.finish();
  print(stdout, "%s: %lld scans, %lld odometry lines\n", arguments.out.c_str(),
        static_cast<long long>(result.scans), static_cast<long long>(result.odometry));
  if (result.true_poses > 0) {
    print(stdout, "%s: %lld true poses (time x y z qx qy qz qw)\n", truth_path.c_str(),
          static_cast<long long>(result.true_poses));
  }
  print_count(result.resampled, "scans resampled to regular bearings; CARMEN has no others");
  print_count(result.without_odometry, "scans had no odometry at their time");
  print_count(result.of_more_lasers, "scans of a third laser left out; CARMEN has two");
  const files::InputReport report = recording->report();
  for (const auto& [cause, count] : report.dropped) print_count(count, cause.c_str());
  for (const std::string& text : report.notes) print(stdout, "  %s\n", text.c_str());
}

ExportFormat carmen_format() {
  auto foreign_table = std::make_shared<std::string>();
  return {"carmen",
          {".carmen", ".log"},
          [foreign_table](const ExportArguments& arguments) {
            write_carmen(arguments, *foreign_table);
          },
          [foreign_table](process::CommandLine& command) {
            command
                .add_option("--foreign", *foreign_table,
                            "carmen: meaning of foreign channels, see config/foreign.toml")
                .existing_file();
          }};
}

struct ImportArguments {
  std::string in, out;
  Existing existing = Existing::refuse;
};

void run_import(const ImportArguments& arguments) {
  process::catch_interrupts(arguments.out + " is unchanged");
  OutputFile out(arguments.out, arguments.existing, {arguments.in});
  ImportResult result;
  {
    LateProgress progress("importing " + std::filesystem::path(arguments.in).filename().string());
    result = import_recording(arguments.in, out, progress.callback());
  }
  require(result.events > 0, arguments.in + ": contains nothing to write as events");
  out.finish();
  print(stdout, "%s: %s, %lld events\n", arguments.out.c_str(), result.report.format.c_str(),
        static_cast<long long>(result.events));
  for (const auto& [kind, count] : result.report.given) print_count(count, kind.c_str());
  for (const auto& [cause, count] : result.report.dropped) {
    print(stdout, "  left out %lld: %s (first: %s)\n", static_cast<long long>(count), cause.c_str(),
          result.report.places.at(cause).c_str());
  }
  for (const std::string& note : result.report.notes) print(stdout, "  %s\n", note.c_str());
}

void add_import(process::CommandLine& program) {
  auto arguments = std::make_shared<ImportArguments>();
  auto command = program.add_subcommand(
      "import",
      "make an LCM log (LIDAR, ODOMETRY, SENSOR_INFO) from a CARMEN log or another recording",
      [arguments] { run_import(*arguments); });
  command.add_option("IN", arguments->in, "recording").required();
  command.add_option("OUT", arguments->out, "log to write").required();
  add_force(command, arguments->existing);
}

// What Marco adds to the log commands: import of recordings, CARMEN export, Foxglove topics in MCAP
// files, the orders to robots, and advice for files that are not an LCM log.
Extensions marco_extensions() {
  return {{carmen_format()},
          [](const LogInfo& log) { return std::make_unique<FoxgloveTranslator>(log); },
          {add_import, add_convert},
          {channels::kRobotOrders.begin(), channels::kRobotOrders.end()},
          [](const std::string& path) { return why_no_log(path); },
          describe_recording};
}

}  // namespace
}  // namespace marco::logs

int main(int argc, char** argv) {
  return marco::logs::run_log_program(argc, argv, marco::logs::marco_extensions());
}
