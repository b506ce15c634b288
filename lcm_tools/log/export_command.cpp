#include <cstdio>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/log/commands.hpp"
#include "lcm_tools/log/export_csv.hpp"
#include "lcm_tools/log/export_images.hpp"
#include "lcm_tools/log/export_json_lines.hpp"
#include "lcm_tools/log/export_mcap.hpp"
#include "lcm_tools/log/late_progress.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "recordings/lcm_log_reader.hpp"
#include "tools/log/export_carmen.hpp"

namespace marco::logs {
namespace {

std::string format_of(const ExportArguments& arguments) {
  if (!arguments.format.empty()) return arguments.format;
  const std::string ending = std::filesystem::path(arguments.out).extension().string();
  if (ending == ".mcap") return "mcap";
  if (ending == ".jsonl") return "jsonl";
  if (ending == ".carmen" || ending == ".log") return "carmen";
  throw std::invalid_argument(arguments.out +
                              ": its ending says no format; give --format csv, jsonl, carmen, mcap "
                              "or images");
}

WalkInput open_input(const ExportArguments& arguments) {
  WalkInput input;
  input.path = arguments.in;
  input.channels = ChannelChoice(arguments.channels, ChannelChoice::Sense::keep);
  input.range = parse_range(arguments.from, arguments.to, span_of_log(arguments.in));
  return input;
}

void tell(const ExportArguments& arguments, const WalkResult& walk) {
  std::printf("%s: %lld events\n", arguments.out.c_str(), static_cast<long long>(walk.events));
  if (walk.undecodable > 0) {
    std::printf(
        "  %lld messages of types that are not known, or broken (--types DIR reads .lcm "
        "sources)\n",
        static_cast<long long>(walk.undecodable));
  }
  if (walk.damage.places > 0) {
    std::printf("  left out %lld bytes at %lld damaged places\n",
                static_cast<long long>(walk.damage.bytes_skipped),
                static_cast<long long>(walk.damage.places));
  }
}

void tell_carmen(const ExportArguments& arguments,
                 const CarmenResult& result,
                 const files::InputReport& report,
                 const std::string& truth_path) {
  std::printf("%s: %lld scans, %lld odometry lines\n", arguments.out.c_str(),
              static_cast<long long>(result.scans), static_cast<long long>(result.odometry));
  if (result.true_poses > 0) {
    std::printf("%s: %lld true poses (time x y z qx qy qz qw)\n", truth_path.c_str(),
                static_cast<long long>(result.true_poses));
  }
  const auto note = [](int64_t count, const char* what) {
    if (count > 0) std::printf("  %lld %s\n", static_cast<long long>(count), what);
  };
  note(result.resampled, "scans put on regular bearings; CARMEN knows no others");
  note(result.without_odometry, "scans had no odometry at their time");
  note(result.of_more_lasers, "scans of a third laser left out; CARMEN knows two");
  for (const auto& [cause, count] : report.dropped) note(count, cause.c_str());
  for (const std::string& text : report.notes) std::printf("  %s\n", text.c_str());
}

int write_carmen(const ExportArguments& arguments) {
  require(arguments.channels.empty() && arguments.from.empty() && arguments.to.empty(),
          "carmen: choose channels and times with `filter` and `cut` first");
  const auto recording =
      open_lcm_log(arguments.in, process::load_options<ForeignTable>(arguments.foreign));
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
  tell_carmen(arguments, result, recording->report(), truth_path);
  return 0;
}

}  // namespace

int run_export(const ExportArguments& arguments) {
  process::catch_interrupts(arguments.out + " is as it was");
  const std::string format = format_of(arguments);
  if (format == "carmen") return write_carmen(arguments);
  const Types types(arguments.types);
  tell_problems(types);
  WalkInput input = open_input(arguments);
  LateProgress progress("writing " + arguments.out);
  if (format == "csv") {
    const CsvResult result =
        export_csv(input, types, arguments.out, arguments.existing, progress.callback());
    tell(arguments, result.walk);
    for (const std::string& name : result.files) std::printf("  %s\n", name.c_str());
  } else if (format == "images") {
    const ImagesResult result =
        export_images(input, types, arguments.out, arguments.existing, progress.callback());
    std::printf("%s: %lld pictures\n", arguments.out.c_str(),
                static_cast<long long>(result.written));
    if (result.broken + result.unknown_format > 0) {
      std::printf("  %lld broken, %lld of other pixel formats left out\n",
                  static_cast<long long>(result.broken),
                  static_cast<long long>(result.unknown_format));
    }
  } else {
    OutputFile out(arguments.out, arguments.existing, {arguments.in});
    if (format == "mcap") {
      const McapResult result = export_mcap(input, types, out, progress.callback());
      out.finish();
      tell(arguments, result.walk);
      std::printf("  %llu messages on %zu topics\n",
                  static_cast<unsigned long long>(result.messages), result.topics);
      if (result.grids_left_out > 0) {
        std::printf("  %lld maps are too large to be drawn: only their tiles were written\n",
                    static_cast<long long>(result.grids_left_out));
      }
    } else {
      const WalkResult result = export_json_lines(input, types, out, progress.callback());
      out.finish();
      tell(arguments, result);
    }
  }
  return 0;
}

}  // namespace marco::logs
