#include <cstdio>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/log/export_csv.hpp"
#include "lcm_tools/log/export_images.hpp"
#include "lcm_tools/log/export_json_lines.hpp"
#include "lcm_tools/log/export_mcap.hpp"
#include "lcm_tools/log/extensions.hpp"
#include "lcm_tools/log/late_progress.hpp"
#include "lcm_tools/process/stop_signal.hpp"

namespace marco::logs {
namespace {

// What the exporters of lcm_tools read: the types, the chosen events, a progress line.
struct Request {
  explicit Request(const ExportArguments& arguments)
      : types(arguments.types),
        input{arguments.in,
              parse_range(arguments.from, arguments.to, span_of_log(arguments.in)),
              {arguments.channels, ChannelChoice::Sense::keep}},
        progress("writing " + arguments.out) {
    print_problems(types);
  }

  Types types;
  WalkInput input;
  LateProgress progress;
};

void print_result(const ExportArguments& arguments, const WalkResult& walk) {
  print(stdout, "%s: %lld events\n", arguments.out.c_str(), static_cast<long long>(walk.events));
  if (walk.undecodable > 0) {
    print(stdout, "  %lld messages of unknown types, or broken (--types DIR reads .lcm sources)\n",
          static_cast<long long>(walk.undecodable));
  }
  if (walk.damage.places > 0) {
    print(stdout, "  skipped %lld bytes at %lld damaged places\n",
          static_cast<long long>(walk.damage.bytes_skipped),
          static_cast<long long>(walk.damage.places));
  }
}

void write_csv(const ExportArguments& arguments) {
  Request request(arguments);
  const CsvResult result = export_csv(request.input, request.types, arguments.out,
                                      arguments.existing, request.progress.callback());
  print_result(arguments, result.walk);
  for (const std::string& name : result.files) print(stdout, "  %s\n", name.c_str());
}

void write_images(const ExportArguments& arguments) {
  Request request(arguments);
  const ImagesResult result = export_images(request.input, request.types, arguments.out,
                                            arguments.existing, request.progress.callback());
  print(stdout, "%s: %lld pictures\n", arguments.out.c_str(),
        static_cast<long long>(result.written));
  if (result.broken + result.unknown_format > 0) {
    print(stdout, "  skipped %lld broken ones and %lld of other pixel formats\n",
          static_cast<long long>(result.broken), static_cast<long long>(result.unknown_format));
  }
}

void write_json_lines(const ExportArguments& arguments) {
  Request request(arguments);
  OutputFile out(arguments.out, arguments.existing, {arguments.in});
  const WalkResult result =
      export_json_lines(request.input, request.types, out, request.progress.callback());
  out.finish();
  print_result(arguments, result);
}

void write_mcap(const ExportArguments& arguments, const MakeMcapTranslator& make_translator) {
  Request request(arguments);
  OutputFile out(arguments.out, arguments.existing, {arguments.in});
  const McapResult result =
      export_mcap(request.input, request.types, out, make_translator, request.progress.callback());
  out.finish();
  print_result(arguments, result.walk);
  print(stdout, "  %llu messages on %zu topics\n", static_cast<unsigned long long>(result.messages),
        result.topics);
  if (!result.remark.empty()) print(stdout, "  %s\n", result.remark.c_str());
}

const ExportFormat& format_of(const ExportArguments& arguments,
                              std::span<const ExportFormat> formats) {
  const std::string ending = std::filesystem::path(arguments.out).extension().string();
  std::string names;
  for (const ExportFormat& format : formats) {
    const bool named = format.name == arguments.format;
    const bool fits =
        arguments.format.empty() &&
        std::find(format.endings.begin(), format.endings.end(), ending) != format.endings.end();
    if (named || fits) return format;
    names += (names.empty() ? "" : ", ") + format.name;
  }
  throw std::invalid_argument(arguments.out +
                              ": no format has this extension; choose one with --format: " + names);
}

}  // namespace

std::vector<ExportFormat> export_formats(const Extensions& extensions) {
  std::vector<ExportFormat> formats = {
      {"csv", {}, write_csv},
      {"jsonl", {".jsonl"}, write_json_lines},
      {"mcap",
       {".mcap"},
       [make = extensions.make_mcap_translator](const ExportArguments& arguments) {
         write_mcap(arguments, make);
       }},
      {"images", {}, write_images}};
  formats.insert(formats.end(), extensions.formats.begin(), extensions.formats.end());
  return formats;
}

void run_export(const ExportArguments& arguments, std::span<const ExportFormat> formats) {
  process::catch_interrupts(arguments.out + " is unchanged");
  format_of(arguments, formats).write(arguments);
}

}  // namespace marco::logs
