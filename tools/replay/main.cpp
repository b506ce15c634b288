#include <cstdio>
#include <set>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/channel_pattern.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "recordings/foreign_messages.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

// What drivers publish. Orders and what was made of them stay out.
const ChannelPattern kOwn(
    "LIDAR.*|SENSOR_INFO|ODOMETRY|IMU|PANTILT_STATE|SONAR|CAMERA(_.*)?|TRUE_POSE(_BY_ARRIVAL)?");

std::set<std::string> inputs_of(const std::string& log, const ForeignTable& table) {
  std::set<std::string> inputs, others;
  files::EventLogReader reader(log);
  while (const auto event = reader.next()) {
    if (inputs.contains(event->channel) || others.contains(event->channel)) continue;
    const ForeignChannel* foreign = entry_of(table, event->channel, fingerprint_in(event->bytes));
    const bool is_input =
        kOwn.matches(event->channel) || (foreign != nullptr && foreign->meaning != "ignore");
    (is_input ? inputs : others).insert(event->channel);
  }
  return inputs;
}

std::string quoted(const std::string& name) {
  std::string text;
  for (const char c : name) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    text += is_plain ? std::string(1, c) : std::string("\\") + c;
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-inputs", [&] {
    process::CommandLine app(
        "Prints the channels of an LCM log that `marco replay` plays, as one regular expression: "
        "the inputs of Marco's programs, including other systems' sensors");
    std::string log, foreign;
    app.add_option("LOG", log).required().existing_file();
    app.add_option("--foreign", foreign,
                   "TOML file with the meaning of other systems' channels: see config/foreign.toml")
        .existing_file();
    if (const auto code = app.parse(argc, argv)) return *code;
    std::string regexp;
    for (const auto& name : inputs_of(log, process::load_options<ForeignTable>(foreign))) {
      regexp += (regexp.empty() ? "" : "|") + quoted(name);
    }
    require(!regexp.empty(), log + ": contains no input channel of Marco's programs");
    std::printf("^(%s)$\n", regexp.c_str());
    return 0;
  });
}
