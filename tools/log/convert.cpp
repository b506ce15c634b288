#include "tools/log/convert.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <memory>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/files/readable.hpp"
#include "lcm_tools/log/export_mcap.hpp"
#include "lcm_tools/log/extensions.hpp"
#include "lcm_tools/log/late_progress.hpp"
#include "lcm_tools/log/output_file.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "recordings/import_recording.hpp"
#include "recordings/recording.hpp"
#include "recordings/ros/bag_writer.hpp"
#include "recordings/ros/open_messages.hpp"
#include "tools/log/export_carmen.hpp"
#include "tools/log/foxglove.hpp"
#include "tools/log/mcap_sink.hpp"
#include "tools/log/ros_copy.hpp"
#include "tools/log/slam_results.hpp"

namespace marco::logs {
namespace {

namespace fs = std::filesystem;

struct ConvertArguments {
  std::string in, out;
  std::string format;  // "" = by the ending of OUT
  std::string foreign;
  Existing existing = Existing::refuse;
};

void print_report(const files::InputReport& report) {
  for (const auto& [cause, count] : report.dropped) {
    print(stdout, "  left out %lld: %s (first: %s)\n", static_cast<long long>(count), cause.c_str(),
          report.places.at(cause).c_str());
  }
  for (const std::string& note : report.notes) print(stdout, "  %s\n", note.c_str());
}

bool is_lcm_log(const fs::path& path) {
  return files::first_bytes(path, 64).find("\xED\xA1\xDA\x01") != std::string::npos;
}

ForeignTable foreign_of(const ConvertArguments& arguments) {
  return process::load_options<ForeignTable>(arguments.foreign);
}

LateProgress progress_of(const ConvertArguments& arguments) {
  return LateProgress("writing " + arguments.out);
}

void to_lcm(const ConvertArguments& arguments) {
  OutputFile out(arguments.out, arguments.existing, {arguments.in});
  LateProgress progress = progress_of(arguments);
  const ImportResult result = import_recording(arguments.in, out, progress.callback());
  require(result.events > 0, arguments.in + ": contains nothing to write as events");
  out.finish();
  print(stdout, "%s: %s, %lld events\n", arguments.out.c_str(), result.report.format.c_str(),
        static_cast<long long>(result.events));
  print_report(result.report);
}

void to_carmen(const ConvertArguments& arguments) {
  const auto recording = open_recording(arguments.in, foreign_of(arguments));
  OutputFile out(arguments.out, arguments.existing, {arguments.in});
  LateProgress progress = progress_of(arguments);
  const CarmenResult result = export_carmen(*recording, out, nullptr, progress.callback());
  require(result.scans > 0, arguments.in + ": contains no scans");
  out.finish();
  print(stdout, "%s: %lld scans, %lld odometry lines\n", arguments.out.c_str(),
        static_cast<long long>(result.scans), static_cast<long long>(result.odometry));
  print_report(recording->report());
}

Utime utime_of(const Sample& sample) {
  return std::visit([](const auto& value) { return value.utime; }, sample);
}

void print_damage(const ros::Damage& damage) {
  if (damage.is_cut_off) print(stdout, "   the recording ends inside a record\n");
  if (damage.places == 0) return;
  print(stdout, "  skipped %lld bytes at %lld damaged places\n",
        static_cast<long long>(damage.bytes), static_cast<long long>(damage.places));
}

// @returns false, and writes nothing, where there are no messages of ROS: a viewer's own, ...
bool copy_ros(const ConvertArguments& arguments, ros::MessageSink& sink) {
  const auto source = ros::open_messages(arguments.in);
  LateProgress progress = progress_of(arguments);
  const RosCopyResult result = copy_messages(*source, sink, progress.callback());
  if (result.messages == 0) return false;
  sink.finish();
  print(stdout, "%s: %s, %lld messages\n", arguments.out.c_str(), source->format().c_str(),
        static_cast<long long>(result.messages));
  for (const auto& [cause, count] : result.left_out) {
    print(stdout, "  left out %lld: %s\n", static_cast<long long>(count), cause.c_str());
  }
  for (const std::string& note : source->notes()) print(stdout, "  %s\n", note.c_str());
  print_damage(source->damage());
  return true;
}

void samples_to_ros(const ConvertArguments& arguments, ros::MessageSink& sink) {
  const auto recording = open_recording(arguments.in, foreign_of(arguments));
  RosExport ros(sink);
  std::unique_ptr<SlamResults> results;
  if (recording->report().format == "LCM log") {
    results = std::make_unique<SlamResults>(arguments.in, ros);
  }
  LateProgress progress = progress_of(arguments);
  const OnProgress show = progress.callback();
  constexpr int64_t kSamplesBetweenProgress = 256;
  for (int64_t count = 1; const auto sample = recording->next(); ++count) {
    if (results) results->write_until(utime_of(*sample));
    ros.add(*sample);
    if (count % kSamplesBetweenProgress == 0) show(recording->progress());
  }
  if (results) results->write_until(Utime::from_us(INT64_MAX));
  require(ros.messages() > 0, arguments.in + ": contains nothing to write as ROS messages");
  sink.finish();
  print(stdout, "%s: %s, %lld messages\n", arguments.out.c_str(),
        recording->report().format.c_str(), static_cast<long long>(ros.messages()));
  if (ros.doubled_scans() > 0) {
    print(stdout, "  left out %lld: the same scans on a second channel\n",
          static_cast<long long>(ros.doubled_scans()));
  }
  print_report(recording->report());
}

template <class Sink, class... More>
void to_ros(const ConvertArguments& arguments, const More&... more) {
  OutputFile out(arguments.out, arguments.existing, {arguments.in});
  Sink sink(out, more...);
  const bool copied = ros::is_message_recording(arguments.in) && copy_ros(arguments, sink);
  if (!copied) samples_to_ros(arguments, sink);
  out.finish();
}

// A log of Marco's channels for the time of the conversion.
struct PassingLog {
  explicit PassingLog(const ConvertArguments& arguments)
      : path(arguments.out + "." + std::to_string(getpid()) + ".lcm") {
    OutputFile log(path, Existing::refuse, {});
    LateProgress progress("reading " + arguments.in);
    const ImportResult result = import_recording(arguments.in, log, progress.callback());
    require(result.events > 0, arguments.in + ": contains nothing to write as events");
    log.finish();
    print_report(result.report);
  }
  ~PassingLog() {
    std::error_code ignored;
    fs::remove(path, ignored);
  }
  PassingLog(const PassingLog&) = delete;
  PassingLog& operator=(const PassingLog&) = delete;

  std::string path;
};

void to_foxglove(const ConvertArguments& arguments) {
  OutputFile out(arguments.out, arguments.existing, {arguments.in});
  std::unique_ptr<PassingLog> passing;
  if (!is_lcm_log(arguments.in)) passing = std::make_unique<PassingLog>(arguments);
  const Types types({});
  WalkInput input;
  input.path = passing ? passing->path : arguments.in;
  LateProgress progress = progress_of(arguments);
  const McapResult result = export_mcap(
      input, types, out,
      [](const LogInfo& log) { return std::make_unique<FoxgloveTranslator>(log); },
      progress.callback());
  out.finish();
  print(stdout, "%s: %llu messages on %zu topics\n", arguments.out.c_str(),
        static_cast<unsigned long long>(result.messages), result.topics);
}

struct Target {
  const char* name;
  const char* ending;  // the first with an ending is what that means
  std::function<void(const ConvertArguments&)> write;
};

const std::array<Target, 7>& targets() {
  static const std::array<Target, 7> kTargets{{
      {"lcm", ".lcm", to_lcm},
      {"carmen", ".log", to_carmen},
      {"carmen", ".carmen", to_carmen},
      {"bag", ".bag", to_ros<ros::BagWriter>},
      {"ros2", ".mcap", [](const auto& arguments) { to_ros<McapSink>(arguments, "cdr"); }},
      {"ros1", "", [](const auto& arguments) { to_ros<McapSink>(arguments, "ros1"); }},
      {"foxglove", "", to_foxglove},
  }};
  return kTargets;
}

void run_convert(const ConvertArguments& arguments) {
  process::catch_interrupts(arguments.out + " is unchanged");
  const std::string ending = fs::path(arguments.out).extension().string();
  std::string names;
  for (const Target& target : targets()) {
    if (arguments.format.empty() ? ending == target.ending : arguments.format == target.name) {
      return target.write(arguments);
    }
    names += std::string(names.empty() ? "" : ", ") + target.name;
  }
  throw std::invalid_argument(arguments.out +
                              ": no format has this extension; choose one with --format: " + names);
}

}  // namespace

void add_convert(process::CommandLine& program) {
  auto arguments = std::make_shared<ConvertArguments>();
  auto command = program.add_subcommand("convert",
                                        "any recording that Marco reads (LCM, CARMEN, ROS "
                                        "bags, MCAP, rosbag2, ...) to an LCM log (.lcm), "
                                        "a CARMEN log (.log, .carmen), a ROS 1 bag (.bag: "
                                        "rosbag play), or an MCAP file (.mcap: ros2 bag "
                                        "play; --format foxglove: for the viewer)",
                                        [arguments] { run_convert(*arguments); });
  command.add_option("IN", arguments->in, "recording").required();
  command.add_option("OUT", arguments->out, "file to write").required();
  command
      .add_option(
          "--format", arguments->format,
          "default: by the extension of OUT. ros2 and ros1: MCAP with messages of ROS 2 or ROS 1")
      .one_of({"lcm", "carmen", "bag", "ros2", "ros1", "foxglove"});
  command
      .add_option("--foreign", arguments->foreign,
                  "meaning of foreign channels and topics, see config/foreign.toml")
      .existing_file();
  add_force(command, arguments->existing);
}

}  // namespace marco::logs
