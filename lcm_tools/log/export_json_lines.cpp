#include "lcm_tools/log/export_json_lines.hpp"

namespace marco::logs {

WalkResult export_json_lines(WalkInput& input,
                             const Types& types,
                             OutputFile& out,
                             const OnProgress& on_progress) {
  lcm_schema::JsonOptions options;
  options.bytes_as_base64 = true;
  std::string line;
  return walk_log(
      input, types,
      [&](const DecodedEvent& event) {
        line = "{\"event\":" + std::to_string(event.head.number) +
               ",\"time_us\":" + std::to_string(event.head.event_time.us) + ",\"channel\":";
        lcm_schema::append_json_string(event.head.channel, line);
        if (event.structure >= 0) {
          line += ",\"type\":";
          const auto index = static_cast<std::size_t>(event.structure);
          lcm_schema::append_json_string(types.schema().structures()[index].name, line);
          line += ",\"message\":";
          lcm_schema::append_json(event.tree, line, options);
        } else {
          const auto fingerprint = lcm_schema::fingerprint_of(event.bytes);
          line += ",\"fingerprint\":\"" +
                  (fingerprint ? lcm_schema::fingerprint_text(*fingerprint) : "") +
                  "\",\"data\":\"" + to_base64(event.bytes) + "\"";
        }
        line += "}\n";
        out.write(std::string_view(line));
      },
      on_progress);
}

}  // namespace marco::logs
