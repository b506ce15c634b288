#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/spy/session.hpp"

namespace marco::spy {

int run_spy_program(int argc, char** argv, const SpyExtensions& extensions) {
  return process::run_main("marco-spy", [&] {
    process::CommandLine app(
        "Shows LCM traffic: channels, types, rates, losses, fields, plots, scans, maps, senders.\n"
        "  marco-spy                          live, on the screen\n"
        "  marco-spy LOG --speed 4            a log, at 4 times its speed\n"
        "  marco-spy --once --json            listens for 2 s and prints one JSON object\n"
        "  marco-spy LOG --once --types DIR   the whole log as a table, types read from DIR/*.lcm");
    SessionOptions options;
    options.extensions = extensions;
    app.add_option("LOG", options.log, "an LCM event log; without it: live");
    app.add_option("--lcm-url", options.lcm_url,
                   "udpm://GROUP:PORT; default: LCM_DEFAULT_URL, else LCM's own");
    app.add_option("--types", options.types,
                   "file or folder of .lcm sources besides the built-in types; repeatable");
    app.add_flag("--once", options.once, "no screen: print one report and exit");
    app.add_flag("--json", options.json,
                 "no screen: print JSON; without --once an object a second");
    app.add_option("--duration", options.duration_s,
                   "[s] to listen (--once: 2), or of the log from its first event (default: all)");
    app.add_option("--speed", options.speed, "of a log on the screen; 0 = at once");
    app.add_option("--channel", options.channel, "opens this channel");
    app.add_option("--page", options.page,
                   "opens a page: who, or with --channel: picture, plot:FIELD");
    app.add_option("--width", options.width, "[cells] of the report of --once").between(0, 1000);
    app.add_option("--height", options.height, "[cells]").between(0, 1000);
    if (const auto code = app.parse(argc, argv)) return *code;
    return run_session(options);
  });
}

}  // namespace marco::spy
