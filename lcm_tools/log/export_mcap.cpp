#include "lcm_tools/log/export_mcap.hpp"

#include <algorithm>
#include <map>

#include "lcm_tools/log/mcap_writer.hpp"
#include "tools/log/foxglove.hpp"

namespace marco::logs {
namespace {

class McapExport {
 public:
  McapExport(const Types& types, OutputFile& out, const LogInfo& log)
      : types_(types), writer_(out), translator_(log) {
    options_.bytes_as_base64 = true;
  }

  void add(const DecodedEvent& event) {
    number_ = event.head.number;
    time_ = event.head.event_time;
    if (event.structure >= 0) {
      json_.clear();
      lcm_schema::append_json(event.tree, json_, options_);
      write(own_topic(event), time_, json_);
    }
    write_all(translator_.translate(event));
  }
  void finish() {
    write_all(translator_.finish());
    writer_.finish();
  }
  int64_t grids_left_out() const { return translator_.grids_left_out(); }
  uint64_t messages() const { return writer_.messages(); }
  std::size_t topics() const { return own_topics_.size() + foxglove_topics_.size(); }

 private:
  void write(uint16_t topic, Utime event_time, std::string_view json) {
    // Times before 1970 are damage; those after 2554 do not fit nanoseconds.
    const int64_t us = std::clamp<int64_t>(event_time.us, 0, INT64_MAX / 1000);
    writer_.write(topic, static_cast<uint32_t>(number_), static_cast<uint64_t>(us) * 1000, json);
  }
  void write_all(const std::vector<FoxgloveMessage>& messages) {
    for (const FoxgloveMessage& message : messages) {
      write(foxglove_topic(message), message.event_time.value_or(time_), message.json);
    }
  }
  uint16_t own_topic(const DecodedEvent& event) {
    const auto [entry, is_new] =
        own_topics_.try_emplace({std::string(event.head.channel), event.structure});
    if (!is_new) return entry->second;
    const auto index = static_cast<std::size_t>(event.structure);
    const lcm_schema::Structure& structure = types_.schema().structures()[index];
    const auto [schema, schema_is_new] = own_schemas_.try_emplace(event.structure);
    if (schema_is_new) {
      schema->second =
          writer_.add_schema(structure.name, "jsonschema",
                             lcm_schema::json_schema(types_.schema(), event.structure, options_));
    }
    char hex[17];
    std::snprintf(hex, sizeof hex, "%016llx",
                  static_cast<unsigned long long>(structure.fingerprint));
    entry->second = writer_.add_channel(schema->second, entry->first.first, "json",
                                        {{"lcm_type", structure.name}, {"lcm_fingerprint", hex}});
    return entry->second;
  }
  uint16_t foxglove_topic(const FoxgloveMessage& message) {
    const auto [entry, is_new] = foxglove_topics_.try_emplace(message.topic);
    if (!is_new) return entry->second;
    const auto [schema, schema_is_new] = foxglove_schemas_.try_emplace(message.schema);
    if (schema_is_new) {
      schema->second =
          writer_.add_schema(message.schema, "jsonschema", foxglove_schema(message.schema));
    }
    entry->second = writer_.add_channel(schema->second, message.topic, "json", {});
    return entry->second;
  }

  const Types& types_;
  McapWriter writer_;
  FoxgloveTranslator translator_;
  lcm_schema::JsonOptions options_;
  std::string json_;
  int64_t number_ = 0;  // of the event in hand
  Utime time_;
  std::map<int, uint16_t> own_schemas_;
  std::map<std::string, uint16_t> foxglove_schemas_;
  std::map<std::pair<std::string, int>, uint16_t> own_topics_;
  std::map<std::string, uint16_t> foxglove_topics_;
};

}  // namespace

McapResult export_mcap(WalkInput& input,
                       const Types& types,
                       OutputFile& out,
                       const OnProgress& on_progress) {
  const auto part = [&on_progress](double from, double share) -> OnProgress {
    return [&on_progress, from, share](double done) { on_progress(from + share * done); };
  };
  LogInfo log = inspect_log(input.path, part(0.0, 0.1));
  std::erase_if(log.channels,
                [&](const ChannelInfo& channel) { return !input.channels.keeps(channel.name); });
  McapExport target(types, out, log);
  McapResult result;
  result.walk = walk_log(
      input, types, [&](const DecodedEvent& event) { target.add(event); }, part(0.1, 0.9));
  target.finish();
  result.messages = target.messages();
  result.topics = target.topics();
  result.grids_left_out = target.grids_left_out();
  return result;
}

}  // namespace marco::logs
