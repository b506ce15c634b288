#include <memory>

#include "lcm_tools/lcmtypes/channels.hpp"
#include "lcm_tools/log/extensions.hpp"
#include "lcm_tools/process/arguments.hpp"

// The command line of marco-log.
namespace marco::logs {

void add_force(process::CommandLine& command, Existing& existing) {
  command.add_flag(
      "-f,--force", [&existing] { existing = Existing::replace; }, "replace existing files");
}

namespace {

constexpr const char* kHelp =
    "Inspects and edits LCM logs. Damaged parts of a log are skipped and reported.\n"
    "Times: seconds from the start (12.5, 1:30), before the end (-10), absolute\n"
    "(@1454600000, 2016-02-04T15:33:20Z).";

// The options that several commands share.
struct Command {
  process::CommandLine app;

  void in(std::string& path) { app.add_option("LOG", path, "LCM log").required(); }
  void in(std::vector<std::string>& paths) { app.add_option("LOG", paths, "LCM logs").required(); }
  void out(const char* name, std::string& path, const char* what = "log to write") {
    app.add_option(name, path, what).required();
  }
  void range(std::string& from, std::string& to) {
    app.add_option("--from", from, "start time");
    app.add_option("--to", to, "end time, exclusive");
  }
  process::Option each(const char* name, auto& values, const char* what) {
    return app.add_option(name, values, what).one_value_each_time();
  }
  process::Option channels(std::vector<std::string>& names) {
    return each("-c,--channel", names, "name or regular expression of the whole name; repeatable");
  }
  void json(Format& format) {
    app.add_flag(
        "--json", [&format] { format = Format::json; }, "print JSON");
  }
  void types(std::vector<std::string>& paths) {
    app.add_option("--types", paths, ".lcm sources (files or folders) besides the built-in types");
  }
};

template <class Arguments>
struct Added {
  Command command;
  Arguments& arguments;
};

// Adds a subcommand that runs `run` with its parsed arguments.
template <class Arguments>
Added<Arguments> add(process::CommandLine& program,
                     const char* name,
                     const char* what,
                     std::function<void(const Arguments&)> run) {
  auto arguments = std::make_shared<Arguments>();
  const auto app =
      program.add_subcommand(name, what, [arguments, run = std::move(run)] { run(*arguments); });
  return {{app}, *arguments};
}

void add_info(process::CommandLine& program, const Extensions& extensions) {
  auto [command, info] = add<InfoArguments>(
      program, "info", "channels, types, rates, gaps, duration, clock offsets, damage", run_info);
  command.in(info.logs);
  command.json(info.format);
  command.types(info.types);
  info.describe = extensions.describe;
}

void add_select(process::CommandLine& program, bool is_cut) {
  auto [command, select] = add<SelectArguments>(
      program, is_cut ? "cut" : "filter",
      is_cut ? "copy the events of a time range" : "copy the events of some channels", run_select);
  command.in(select.in);
  command.out("OUT", select.out);
  command.range(select.from, select.to);
  command.channels(select.channels).required(!is_cut);
  command.app.add_flag("-v,--drop", select.drop, "drop these channels, keep the others");
  add_force(command.app, select.existing);
}

void add_merge(process::CommandLine& program) {
  auto [command, merge] =
      add<MergeArguments>(program, "merge", "merge several logs by event time", run_merge);
  command.in(merge.ins);
  command.out("-o,--out", merge.out);
  command.each("--shift", merge.shifts_s, "[s] added to the event times; once for each log");
  command.each("--prefix", merge.prefixes,
               "prepended to the channels; once for each log, \"\" = none");
  add_force(command.app, merge.existing);
}

void add_repair(process::CommandLine& program) {
  auto [command, repair] = add<RepairArguments>(
      program, "repair", "keep every complete event of a damaged log and repair headers",
      run_repair);
  command.in(repair.in);
  command.out("OUT", repair.out);
  command.app.add_flag("--as-is", repair.as_is, "repair nothing; copy complete events only");
  command.json(repair.format);
  command.types(repair.types);
  add_force(command.app, repair.existing);
}

void add_recordings(process::CommandLine& program) {
  auto [list, arguments] = add<RecordingsArguments>(
      program, "recordings", "list the recordings of marco-recorder: name, length, size, kept",
      run_recordings);
  list.app.add_option("FOLDER", arguments.home, "default: $MARCO_RUN/recordings, or ./recordings");
  auto [keep, kept] =
      add<KeepArguments>(program, "keep", "never delete these recordings to make room", run_keep);
  keep.app.add_option("RECORDING", kept.recordings, "name or folder").required();
  keep.app.add_flag("--undo", kept.undo, "permit deletion again");
}

void add_export(process::CommandLine& program, const Extensions& extensions) {
  std::vector<std::string> names;
  const std::vector<ExportFormat> formats = export_formats(extensions);
  names.reserve(formats.size());
  for (const ExportFormat& format : formats) names.push_back(format.name);
  auto [command, request] = add<ExportArguments>(
      program, "export", "convert to another format",
      [formats](const ExportArguments& arguments) { run_export(arguments, formats); });
  command.in(request.in);
  command.out("OUT", request.out, "file; for csv and images a folder");
  command.app.add_option("--format", request.format, "default: by the extension of OUT")
      .one_of(names);
  command.range(request.from, request.to);
  command.channels(request.channels);
  command.types(request.types);
  for (const ExportFormat& format : formats) {
    if (format.add_options) format.add_options(command.app);
  }
  add_force(command.app, request.existing);
}

void add_play(process::CommandLine& program, const Extensions& extensions) {
  auto [command, play] = add<PlayArguments>(program, "play",
                                            "publish a log in real time; on a terminal: space "
                                            "pause, s step, arrows seek and speed, h help",
                                            run_play);
  play.order_channels.assign(channels::kToolOrders.begin(), channels::kToolOrders.end());
  play.order_channels.insert(play.order_channels.end(), extensions.order_channels.begin(),
                             extensions.order_channels.end());
  command.in(play.in);
  command.app.add_option("-s,--speed", play.speed, "multiple of real time; 0 = as fast as possible")
      .not_negative()
      .shows_default();
  command.range(play.from, play.to);
  command.app.add_flag("--loop", play.loop, "start again at the end");
  command.app.add_flag("--pause", play.paused, "wait for a key before the first event");
  command.app
      .add_option("--longest-wait", play.longest_wait_s, "[s] longer gaps are shortened to this")
      .positive();
  command.channels(play.channels);
  command.app.add_flag("-v,--drop", play.drop, "drop these channels, play the others");
  command.each("--rename", play.renames,
               "OLD=NEW; OLD may be a regular expression, NEW may use $1; repeatable");
  command.app.add_option("-l,--lcm-url", play.lcm_url,
                         "default: LCM_DEFAULT_URL, or this host only");
  command.app.add_flag("--orders", play.orders,
                       "also publish orders (EMERGENCY_STOP, ...); running robots obey them");
  command.app.add_flag(
      "--no-keys", [&arguments = play] { arguments.keys = false; }, "ignore the keyboard");
}

int parse_and_run(int argc, char** argv, const Extensions& extensions) {
  process::CommandLine app(kHelp, "marco-log");
  app.require_subcommand();
  add_info(app, extensions);
  add_select(app, true);
  add_select(app, false);
  add_merge(app);
  add_repair(app);
  add_recordings(app);
  for (const auto& add_command : extensions.commands) add_command(app);
  add_export(app, extensions);
  add_play(app, extensions);
  try {
    return app.parse(argc, argv).value_or(0);
  } catch (const NoLogError& none) {
    if (!extensions.explain_no_log) throw;
    throw std::invalid_argument(extensions.explain_no_log(none.path()) + none.outcome());
  }
}

}  // namespace

int run_log_program(int argc, char** argv, const Extensions& extensions) {
  return process::run_main("marco-log", [&] { return parse_and_run(argc, argv, extensions); });
}

}  // namespace marco::logs
