#include "lcm_tools/log/export_mcap.hpp"

#include <algorithm>
#include <map>

#include "lcm_tools/log/mcap_writer.hpp"

namespace marco::logs {
namespace {

// Event times before 1970 are damage; those after 2554 do not fit nanoseconds.
uint64_t time_ns(Utime time) {
  return static_cast<uint64_t>(std::clamp<int64_t>(time.us, 0, INT64_MAX / 1000)) * 1000;
}

class McapExport {
 public:
  McapExport(const Types& types, OutputFile& out) : types_(types), writer_(out) {
    options_.bytes_as_base64 = true;
  }

  void add_original(const DecodedEvent& event) {
    if (event.structure < 0) return;
    json_.clear();
    lcm_schema::append_json(event.tree, json_, options_);
    write(original_topic(event), event.head, event.head.event_time, json_);
  }
  void add(const std::vector<AddedMessage>& messages,
           const McapTranslator& translator,
           const files::LogEventHead& head) {
    for (const AddedMessage& message : messages) {
      write(added_topic(message, translator), head, message.event_time.value_or(head.event_time),
            message.json);
    }
  }
  void finish(McapResult& result) {
    writer_.finish();
    result.messages = writer_.messages();
    result.topics = topics_.size();
  }

 private:
  void write(uint16_t topic,
             const files::LogEventHead& head,
             Utime event_time,
             std::string_view json) {
    const uint64_t ns = time_ns(event_time);
    writer_.write(topic, static_cast<uint32_t>(head.number), {ns, ns}, json);
  }
  uint16_t original_topic(const DecodedEvent& event) {
    const auto [topic, is_new] = topics_.try_emplace(Key(event.head.channel, event.structure));
    if (!is_new) return topic->second;
    const lcm_schema::Structure& type =
        types_.schema().structures()[static_cast<std::size_t>(event.structure)];
    const auto [schema, schema_is_new] = schemas_.try_emplace(Key(type.name, event.structure));
    if (schema_is_new) {
      schema->second =
          writer_.add_schema(type.name, "jsonschema",
                             lcm_schema::json_schema(types_.schema(), event.structure, options_));
    }
    return topic->second = writer_.add_channel(
               schema->second, topic->first.first, "json",
               {{"lcm_type", type.name},
                {"lcm_fingerprint", lcm_schema::fingerprint_text(type.fingerprint)}});
  }
  uint16_t added_topic(const AddedMessage& message, const McapTranslator& translator) {
    const auto [topic, is_new] = topics_.try_emplace(Key(message.topic, kAdded));
    if (!is_new) return topic->second;
    const auto [schema, schema_is_new] = schemas_.try_emplace(Key(message.schema, kAdded));
    if (schema_is_new) {
      schema->second =
          writer_.add_schema(message.schema, "jsonschema", translator.json_schema(message.schema));
    }
    return topic->second = writer_.add_channel(schema->second, message.topic, "json", {});
  }

  static constexpr int kAdded = -1;  // in place of a structure's index
  using Key = std::pair<std::string, int>;

  const Types& types_;
  McapWriter writer_;
  lcm_schema::JsonOptions options_;
  std::string json_;
  std::map<Key, uint16_t> schemas_;
  std::map<Key, uint16_t> topics_;
};

}  // namespace

McapResult export_mcap(WalkInput& input,
                       const Types& types,
                       OutputFile& out,
                       const MakeMcapTranslator& make_translator,
                       const OnProgress& on_progress) {
  std::unique_ptr<McapTranslator> translator;
  double surveyed = 0.0;  // part of the progress
  if (make_translator) {
    surveyed = 0.1;
    LogInfo log = inspect_log(input.path, [&](double done) { on_progress(surveyed * done); });
    std::erase_if(log.channels,
                  [&](const ChannelInfo& channel) { return !input.channels.keeps(channel.name); });
    translator = make_translator(log);
  }
  McapExport target(types, out);
  McapResult result;
  files::LogEventHead last;
  result.walk = walk_log(
      input, types,
      [&](const DecodedEvent& event) {
        last.number = event.head.number;
        last.event_time = event.head.event_time;
        target.add_original(event);
        if (translator) target.add(translator->translate(event), *translator, last);
      },
      [&](double done) { on_progress(surveyed + (1.0 - surveyed) * done); });
  if (translator) {
    target.add(translator->finish(), *translator, last);
    result.remark = translator->remark();
  }
  target.finish(result);
  return result;
}

}  // namespace marco::logs
