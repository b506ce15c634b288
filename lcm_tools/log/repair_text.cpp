#include <nlohmann/json.hpp>

#include "lcm_tools/log/repair.hpp"

namespace marco::logs {

std::string to_text(const RepairReport& report) {
  constexpr std::size_t kShown = 12;
  std::string text = "events written   " + std::to_string(report.events) + "\n";
  text += "  as they were   " + std::to_string(report.untouched) + "\n";
  text += "  repaired       " + std::to_string(report.events - report.untouched) + "\n";
  for (const auto& [what, count] : report.mended) {
    text += "    " + what + ": " + std::to_string(count) + "\n";
  }
  std::size_t shown = 0;
  for (const auto& mended : report.mended_events) {
    if (++shown > kShown) {
      text += "    ...\n";
      break;
    }
    text += "    event " + std::to_string(mended.number) + " (" + mended.channel + ") at byte " +
            std::to_string(mended.offset) + ": " + mended.what + "\n";
  }
  text += "lost             " + std::to_string(report.lost_bytes) + " bytes at " +
          std::to_string(report.lost_places) + " places\n";
  shown = 0;
  for (const auto& lost : report.lost) {
    if (++shown > kShown) {
      text += "    ...\n";
      break;
    }
    text += "    " + std::to_string(lost.bytes) + " bytes at byte " + std::to_string(lost.offset) +
            "\n";
  }
  text +=
      "event numbers missing between first and last: " + std::to_string(report.missing_numbers) +
      "\n";
  int64_t undecodable = 0;
  for (const auto& [channel, count] : report.undecodable) undecodable += count;
  if (undecodable > 0) {
    text += "kept, but their messages do not decode: " + std::to_string(undecodable) + " (";
    bool first = true;
    for (const auto& [channel, count] : report.undecodable) {
      text += (first ? "" : ", ") + channel + " " + std::to_string(count);
      first = false;
    }
    text += ")\n";
  }
  return text;
}

std::string to_json(const RepairReport& report) {
  using Json = nlohmann::ordered_json;
  Json mended = Json::array(), lost = Json::array();
  for (const auto& event : report.mended_events) {
    mended.push_back({{"number", event.number},
                      {"offset", event.offset},
                      {"channel", event.channel},
                      {"what", event.what}});
  }
  for (const auto& stretch : report.lost) {
    lost.push_back({{"offset", stretch.offset}, {"bytes", stretch.bytes}});
  }
  const Json json = {
      {"events", report.events},           {"untouched", report.untouched},
      {"mended", report.mended},           {"mended_events", std::move(mended)},
      {"lost_places", report.lost_places}, {"lost_bytes", report.lost_bytes},
      {"lost", std::move(lost)},           {"missing_numbers", report.missing_numbers},
      {"undecodable", report.undecodable}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace marco::logs
