#include "lcm_tools/log/commands.hpp"

#include <cstdio>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/log/late_progress.hpp"
#include "lcm_tools/log/log_info.hpp"
#include "lcm_tools/log/merge.hpp"
#include "lcm_tools/log/repair.hpp"
#include "lcm_tools/log/types.hpp"
#include "lcm_tools/process/stop_signal.hpp"

namespace marco::logs {
namespace {

std::string name_of(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

void print_damage(const std::string& path, const files::LogDamage& damage) {
  if (damage.places == 0) return;
  print(stdout, "%s: skipped %lld bytes at %lld damaged places, the first at byte %lld\n",
        path.c_str(), static_cast<long long>(damage.bytes_skipped),
        static_cast<long long>(damage.places), static_cast<long long>(damage.first_offset));
}

// JSON has escapes of its own.
void show(const std::string& text, Format format) {
  std::fputs((format == Format::json ? text : printable(text, Newline::kept)).c_str(), stdout);
}

}  // namespace

void run_info(const InfoArguments& arguments) {
  const Types types(arguments.types);
  print_problems(types);
  const TypeNames type_name = [&types](uint64_t fingerprint) { return types.name_of(fingerprint); };
  for (const std::string& path : arguments.logs) {
    if (const auto other =
            arguments.describe ? arguments.describe(path, arguments.format) : std::nullopt) {
      show(*other, arguments.format);
      continue;
    }
    LogInfo info;
    {
      LateProgress progress("reading " + name_of(path));
      info = inspect_log(path, progress.callback());
    }
    if (info.events == 0) throw NoLogError(path);
    const std::string text = arguments.format == Format::json ? to_json(info, path, type_name)
                                                              : to_text(info, path, type_name);
    show(text, arguments.format);
  }
}

void run_select(const SelectArguments& arguments) {
  process::catch_interrupts(arguments.out + " is unchanged");
  const TimeRange range = parse_range(arguments.from, arguments.to, span_of_log(arguments.in));
  ChannelChoice channels(arguments.channels,
                         arguments.drop ? ChannelChoice::Sense::drop : ChannelChoice::Sense::keep);
  OutputFile out(arguments.out, arguments.existing, {arguments.in});
  SelectResult result;
  {
    LateProgress progress("reading " + name_of(arguments.in));
    result = select_events(arguments.in, out, range, channels, progress.callback());
  }
  require(result.kept > 0, arguments.in + ": none of its " + std::to_string(result.events) +
                               " events matches; nothing was written");
  out.finish();
  print_damage(arguments.in, result.damage);
  print(stdout, "%s: %lld of %lld events, %lld bytes\n", arguments.out.c_str(),
        static_cast<long long>(result.kept), static_cast<long long>(result.events),
        static_cast<long long>(result.kept_bytes));
}

void run_merge(const MergeArguments& arguments) {
  process::catch_interrupts(arguments.out + " is unchanged");
  const std::size_t count = arguments.ins.size();
  require(arguments.shifts_s.empty() || arguments.shifts_s.size() == count,
          "--shift: give one for each log");
  require(arguments.prefixes.empty() || arguments.prefixes.size() == count,
          "--prefix: give one for each log");
  std::vector<MergeInput> inputs;
  for (std::size_t i = 0; i < count; ++i) {
    MergeInput& input = inputs.emplace_back();
    input.path = arguments.ins[i];
    if (!arguments.shifts_s.empty()) input.shift = Duration::from_seconds(arguments.shifts_s[i]);
    if (!arguments.prefixes.empty()) input.prefix = arguments.prefixes[i];
  }
  OutputFile out(arguments.out, arguments.existing, {arguments.ins.begin(), arguments.ins.end()});
  MergeResult result;
  {
    LateProgress progress("merging " + std::to_string(count) + " logs");
    result = merge_logs(inputs, out, progress.callback());
  }
  for (std::size_t i = 0; i < count; ++i) {
    const bool no_log = result.events[i] == 0 && std::filesystem::file_size(arguments.ins[i]) > 0;
    if (no_log) throw NoLogError(arguments.ins[i]);
  }
  out.finish();
  int64_t total = 0;
  for (std::size_t i = 0; i < count; ++i) {
    print_damage(arguments.ins[i], result.damage[i]);
    print(stdout, "%s: %lld events\n", arguments.ins[i].c_str(),
          static_cast<long long>(result.events[i]));
    total += result.events[i];
  }
  print(stdout, "%s: %lld events\n", arguments.out.c_str(), static_cast<long long>(total));
}

void run_repair(const RepairArguments& arguments) {
  process::catch_interrupts(arguments.out + " is unchanged");
  const Types types(arguments.types);
  print_problems(types);
  OutputFile out(arguments.out, arguments.existing, {arguments.in});
  RepairReport report;
  {
    LateProgress progress("repairing " + name_of(arguments.in));
    report = repair_log(
        arguments.in, out, arguments.as_is ? Mending::nothing : Mending::headers,
        [&types](std::span<const uint8_t> message) { return types.decodes(message); },
        progress.callback());
  }
  if (report.events == 0) throw NoLogError(arguments.in, "; nothing was written");
  out.finish();
  const std::string text = arguments.format == Format::json ? to_json(report) : to_text(report);
  show(text, arguments.format);
}

}  // namespace marco::logs
