#include <cmath>
#include <nlohmann/json.hpp>

#include "lcm_tools/base/amounts.hpp"
#include "lcm_tools/log/log_info.hpp"
#include "lcm_tools/schema/schema.hpp"

namespace marco::logs {
namespace {

std::string type_text(uint64_t fingerprint, const TypeNames& type_names) {
  if (fingerprint == 0) return "(text)";
  const std::string name = type_names(fingerprint);
  return name.empty() ? "? " + lcm_schema::fingerprint_text(fingerprint) : name;
}

std::string table_row(const ChannelInfo& channel, const TypeNames& type_names) {
  const uint64_t type =
      std::max_element(channel.types.begin(), channel.types.end(), [](auto& a, auto& b) {
        return a.second < b.second;
      })->first;
  std::string types = type_text(type, type_names);
  if (channel.types.size() > 1) types += format(" +%zu", channel.types.size() - 1);
  const double seconds = std::max(1e-6, (channel.last - channel.first).seconds());
  const bool rated = channel.rate_hz > 0.0;
  return format(
      "%-22s %-26s %9lld %9s %9s %9s %10s %s\n", channel.name.c_str(), types.c_str(),
      static_cast<long long>(channel.events), rated ? format("%.2f", channel.rate_hz).c_str() : "-",
      rated ? span_text(channel.usual_interval.seconds()).c_str() : "-",
      rated ? span_text(channel.longest_interval.seconds()).c_str() : "-",
      size_text(static_cast<double>(channel.data_bytes)).c_str(),
      rated ? (size_text(static_cast<double>(channel.data_bytes) / seconds) + "/s").c_str() : "-");
}

void add_channel_remarks(std::string& text, const LogInfo& info, const ChannelInfo& channel) {
  const char* name = channel.name.c_str();
  if (!channel.silences.empty()) {
    const Silence& longest = channel.silences.front();
    text += format("  gap       %s: nothing for %s, %s after the start", name,
                   span_text(longest.length.seconds()).c_str(),
                   span_text((longest.from - info.first).seconds()).c_str());
    const std::size_t more = channel.silences.size() - 1;
    text += more > 0 ? format(" (and %zu shorter ones)\n", more) : "\n";
  }
  if (channel.clock && drifts(*channel.clock)) {
    text +=
        format("  clock     %s: drifts %+.0f ppm against the event times, %s in all\n", name,
               channel.clock->drift_us_per_s, span_text(channel.clock->drifted.seconds()).c_str());
  }
  if (channel.utime_steps_back > 0) {
    text += format("  clock     %s: %lld stamps step backwards\n", name,
                   static_cast<long long>(channel.utime_steps_back));
  }
  if (channel.types.size() > 1) {
    text += format("  types     %s: %zu fingerprints:", name, channel.types.size());
    int shown = 0;
    for (const auto& [type, count] : channel.types) {
      if (++shown > 4) break;
      text += format(" %s x%lld", lcm_schema::fingerprint_text(type).c_str(),
                     static_cast<long long>(count));
    }
    text += "\n";
  }
}

void add_clock_groups(std::string& text, const LogInfo& info) {
  constexpr double kNoticedS = 0.5;
  const bool one = info.clock_groups.size() == 1;
  for (const ClockGroup& group : info.clock_groups) {
    const double behind_s = group.offset.seconds();
    if (one && std::abs(behind_s) < kNoticedS) continue;
    std::string names;
    for (const std::string& name : group.channels) names += (names.empty() ? "" : ", ") + name;
    text += "  clock     " + names;
    text += std::abs(behind_s) < kNoticedS ? ": stamps run with the event times\n"
                                           : format(": stamps are %s %s the event times\n",
                                                    span_text(std::abs(behind_s)).c_str(),
                                                    behind_s > 0 ? "behind" : "ahead of");
  }
}

void add_damage(std::string& text, const LogInfo& info) {
  if (info.damage.places == 0) return;
  text += format("  damage    %lld places, %lld bytes belong to no whole event:",
                 static_cast<long long>(info.damage.places),
                 static_cast<long long>(info.damage.bytes_skipped));
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < std::min(kShown, info.stretches.size()); ++i) {
    text += format(" %lld at byte %lld%s", static_cast<long long>(info.stretches[i].bytes),
                   static_cast<long long>(info.stretches[i].offset),
                   i + 1 < info.stretches.size() ? "," : "");
  }
  if (info.damage.places > static_cast<int64_t>(kShown)) text += " ...";
  text += "\n            marco-log repair writes a log without it\n";
}

}  // namespace

std::string to_text(const LogInfo& info, const std::string& name, const TypeNames& type_names) {
  std::string text = format("%s: %s, %lld events on %zu channels, %s\n  from %s\n  to   %s\n",
                            name.c_str(), size_text(static_cast<double>(info.size_bytes)).c_str(),
                            static_cast<long long>(info.events), info.channels.size(),
                            span_text((info.last - info.first).seconds()).c_str(),
                            to_text(info.first).c_str(), to_text(info.last).c_str());
  text += format("%-22s %-26s %9s %9s %9s %9s %10s %s\n", "channel", "type", "events", "Hz",
                 "interval", "longest", "data", "bandwidth");
  for (const ChannelInfo& channel : info.channels) text += table_row(channel, type_names);
  std::string remarks;
  add_clock_groups(remarks, info);
  for (const ChannelInfo& channel : info.channels) add_channel_remarks(remarks, info, channel);
  if (info.event_time_steps_back > 0) {
    remarks += format("  order     %lld events are earlier than the one before them\n",
                      static_cast<long long>(info.event_time_steps_back));
  }
  add_damage(remarks, info);
  if (!remarks.empty()) text += "to know:\n" + remarks;
  return text;
}

std::string to_json(const LogInfo& info, const std::string& name, const TypeNames& type_names) {
  using Json = nlohmann::ordered_json;
  Json channels = Json::array();
  for (const ChannelInfo& channel : info.channels) {
    Json types = Json::array();
    for (const auto& [type, count] : channel.types) {
      types.push_back({{"fingerprint", type == 0 ? "" : lcm_schema::fingerprint_text(type)},
                       {"type", type == 0 ? "" : type_names(type)},
                       {"events", count}});
    }
    Json gaps = Json::array();
    for (const Silence& silence : channel.silences) {
      gaps.push_back({{"from_us", silence.from.us}, {"length_s", silence.length.seconds()}});
    }
    Json json = {{"channel", channel.name},
                 {"types", std::move(types)},
                 {"events", channel.events},
                 {"data_bytes", channel.data_bytes},
                 {"first_us", channel.first.us},
                 {"last_us", channel.last.us},
                 {"rate_hz", channel.rate_hz},
                 {"usual_interval_s", channel.usual_interval.seconds()},
                 {"longest_interval_s", channel.longest_interval.seconds()},
                 {"gaps", std::move(gaps)},
                 {"clock", nullptr}};
    if (channel.clock) {
      json["clock"] = {{"event_time_minus_utime_s", channel.clock->offset.seconds()},
                       {"drift_ppm", channel.clock->drift_us_per_s},
                       {"steps_back", channel.utime_steps_back},
                       {"group", channel.clock->group}};
    }
    channels.push_back(std::move(json));
  }
  Json stretches = Json::array();
  for (const DamagedStretch& stretch : info.stretches) {
    stretches.push_back({{"offset", stretch.offset}, {"bytes", stretch.bytes}});
  }
  Json groups = Json::array();
  for (const ClockGroup& group : info.clock_groups) {
    groups.push_back(
        {{"event_time_minus_utime_s", group.offset.seconds()}, {"channels", group.channels}});
  }
  const Json json = {{"log", name},
                     {"size_bytes", info.size_bytes},
                     {"events", info.events},
                     {"first_us", info.first.us},
                     {"last_us", info.last.us},
                     {"duration_s", (info.last - info.first).seconds()},
                     {"event_time_steps_back", info.event_time_steps_back},
                     {"channels", std::move(channels)},
                     {"clocks_disagree", groups.size() > 1},
                     {"clock_groups", std::move(groups)},
                     {"damage",
                      {{"places", info.damage.places},
                       {"bytes", info.damage.bytes_skipped},
                       {"stretches", std::move(stretches)}}}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace marco::logs
