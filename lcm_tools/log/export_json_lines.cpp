#include "lcm_tools/log/export_json_lines.hpp"

namespace marco::logs {

std::string to_base64(std::span<const uint8_t> bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8U | (k < count ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? kDigits[(group >> (18 - 6 * k)) & 63U] : '=';
    }
  }
  return text;
}

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
          char hex[17] = "";
          if (const auto fingerprint = lcm_schema::fingerprint_of(event.bytes)) {
            std::snprintf(hex, sizeof hex, "%016llx",
                          static_cast<unsigned long long>(*fingerprint));
          }
          line += ",\"fingerprint\":\"" + std::string(hex) + "\",\"data\":\"" +
                  to_base64(event.bytes) + "\"";
        }
        line += "}\n";
        out.write(std::string_view(line));
      },
      on_progress);
}

}  // namespace marco::logs
