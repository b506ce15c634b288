#include <CLI/CLI.hpp>

#include "lcm_tools/log/commands.hpp"
#include "lcm_tools/process/arguments.hpp"

namespace {

using marco::logs::Existing;

constexpr const char* kHelp =
    "Looks into LCM logs and works on them. A damaged log is read on behind the damage.\n"
    "Moments: seconds from the start (12.5, 1:30), before the end (-10), absolute\n"
    "(@1454600000, 2016-02-04T15:33:20Z).";

void add_force(CLI::App* command, Existing& existing) {
  command->add_flag_callback(
      "-f,--force", [&existing] { existing = Existing::replace; }, "replace what is there");
}

void add_types(CLI::App* command, std::vector<std::string>& types) {
  command->add_option("--types", types,
                      ".lcm sources (files or folders) besides the built-in ones");
}

void add_info(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "info", "channels, types, rates, gaps, duration, clocks that disagree, damage");
  auto arguments = std::make_shared<marco::logs::InfoArguments>();
  command->add_option("LOG", arguments->logs, "LCM logs")->required();
  command->add_flag_callback(
      "--json", [arguments] { arguments->format = marco::logs::Format::json; }, "print JSON");
  add_types(command, arguments->types);
  command->callback([arguments, &exit_code] { exit_code = marco::logs::run_info(*arguments); });
}

void add_select(CLI::App& app, int& exit_code, bool is_cut) {
  CLI::App* command =
      is_cut ? app.add_subcommand("cut", "the events of a time range, as they are")
             : app.add_subcommand("filter", "the events of some channels, as they are");
  auto arguments = std::make_shared<marco::logs::SelectArguments>();
  command->add_option("LOG", arguments->in, "LCM log")->required();
  command->add_option("OUT", arguments->out, "log to write")->required();
  command->add_option("--from", arguments->from, "first moment");
  command->add_option("--to", arguments->to, "moment behind the last");
  command
      ->add_option("-c,--channel", arguments->channels,
                   "name or regular expression of a whole name; may be repeated")
      ->allow_extra_args(false)
      ->required(!is_cut);
  command->add_flag("-v,--drop", arguments->drop, "drop these channels, keep the others");
  add_force(command, arguments->existing);
  command->callback([arguments, &exit_code] { exit_code = marco::logs::run_select(*arguments); });
}

void add_merge(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("merge", "one log of several, by event time");
  auto arguments = std::make_shared<marco::logs::MergeArguments>();
  command->add_option("LOG", arguments->ins, "LCM logs")->required();
  command->add_option("-o,--out", arguments->out, "log to write")->required();
  command
      ->add_option("--shift", arguments->shifts_s,
                   "[s] added to the event times; repeated, one for each log")
      ->allow_extra_args(false);
  command
      ->add_option("--prefix", arguments->prefixes,
                   "put before the channels; repeated, one for each log, \"\" = none")
      ->allow_extra_args(false);
  add_force(command, arguments->existing);
  command->callback([arguments, &exit_code] { exit_code = marco::logs::run_merge(*arguments); });
}

void add_repair(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("repair", "every whole event of a damaged log, and what can be mended");
  auto arguments = std::make_shared<marco::logs::RepairArguments>();
  command->add_option("LOG", arguments->in, "LCM log")->required();
  command->add_option("OUT", arguments->out, "log to write")->required();
  command->add_flag("--as-is", arguments->as_is, "mend nothing: whole events only");
  command->add_flag_callback(
      "--json", [arguments] { arguments->format = marco::logs::Format::json; },
      "print the report as JSON");
  add_types(command, arguments->types);
  add_force(command, arguments->existing);
  command->callback([arguments, &exit_code] { exit_code = marco::logs::run_repair(*arguments); });
}

void add_import(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "import", "an LCM log (LIDAR, ODOMETRY, SENSOR_INFO) of a CARMEN log or another recording");
  auto arguments = std::make_shared<marco::logs::ImportArguments>();
  command->add_option("IN", arguments->in, "recording")->required();
  command->add_option("OUT", arguments->out, "log to write")->required();
  add_force(command, arguments->existing);
  command->callback([arguments, &exit_code] { exit_code = marco::logs::run_import(*arguments); });
}

void add_export(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("export", "CSV, JSON lines, CARMEN, MCAP, pictures");
  auto arguments = std::make_shared<marco::logs::ExportArguments>();
  command->add_option("LOG", arguments->in, "LCM log")->required();
  command->add_option("OUT", arguments->out, "file; for csv and images a folder")->required();
  command->add_option("--format", arguments->format, "default: by OUT's ending")
      ->check(CLI::IsMember({"csv", "jsonl", "carmen", "mcap", "images"}));
  command->add_option("--from", arguments->from, "first moment");
  command->add_option("--to", arguments->to, "moment behind the last");
  command
      ->add_option("-c,--channel", arguments->channels,
                   "name or regular expression of a whole name; may be repeated")
      ->allow_extra_args(false);
  add_types(command, arguments->types);
  command
      ->add_option("--foreign", arguments->foreign,
                   "carmen: what foreign channels mean, see config/foreign.toml")
      ->check(CLI::ExistingFile);
  add_force(command, arguments->existing);
  command->callback([arguments, &exit_code] { exit_code = marco::logs::run_export(*arguments); });
}

void add_play(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("play",
                                         "publish a log as it was; at the terminal: space pause, s "
                                         "step, arrows seek and speed, h help");
  auto arguments = std::make_shared<marco::logs::PlayArguments>();
  command->add_option("LOG", arguments->in, "LCM log")->required();
  command->add_option("-s,--speed", arguments->speed, "times real time; 0 = as fast as possible")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--from", arguments->from, "first moment");
  command->add_option("--to", arguments->to, "moment behind the last");
  command->add_flag("--loop", arguments->loop, "begin again at the end");
  command->add_flag("--pause", arguments->paused, "wait for a key before the first event");
  command
      ->add_option("--longest-wait", arguments->longest_wait_s,
                   "[s] longer silences are shortened to it")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("-c,--channel", arguments->channels,
                   "name or regular expression of a whole name; may be repeated")
      ->allow_extra_args(false);
  command->add_flag("-v,--drop", arguments->drop, "drop these channels, play the others");
  command
      ->add_option("--rename", arguments->renames,
                   "OLD=NEW; OLD may be a regular expression, NEW use $1; may be repeated")
      ->allow_extra_args(false);
  command->add_option("-l,--lcm-url", arguments->lcm_url,
                      "default: LCM_DEFAULT_URL, or this host only");
  command->add_flag("--orders", arguments->orders,
                    "play orders too (BASE_COMMAND, GAMEPAD, ...); robots that run obey them");
  command->add_flag_callback(
      "--no-keys", [arguments] { arguments->keys = false; }, "do not listen to the keyboard");
  command->callback([arguments, &exit_code] { exit_code = marco::logs::run_play(*arguments); });
}

}  // namespace

int main(int argc, char** argv) {
  return marco::process::run_main("marco-log", [&] {
    CLI::App app(kHelp, "marco-log");
    app.require_subcommand(1);
    int exit_code = 0;
    add_info(app, exit_code);
    add_select(app, exit_code, true);
    add_select(app, exit_code, false);
    add_merge(app, exit_code);
    add_repair(app, exit_code);
    add_import(app, exit_code);
    add_export(app, exit_code);
    add_play(app, exit_code);
    if (const auto code = marco::process::parse_arguments(app, argc, argv)) return *code;
    return exit_code;
  });
}
