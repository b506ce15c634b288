#include "lcm_tools/spy/report.hpp"

#include <cstdio>

#include "lcm_tools/schema/json.hpp"

namespace marco::spy {
namespace {

// Writes {...} and [...] with the commas in the right places.
class Json {
 public:
  explicit Json(std::string& out) : out_(out) {}

  Json& open(char bracket) {
    comma();
    out_ += bracket;
    fresh_ = true;
    return *this;
  }
  Json& close(char bracket) {
    out_ += bracket;
    fresh_ = false;
    return *this;
  }
  Json& key(std::string_view name) {
    comma();
    lcm_schema::append_json_string(name, out_);
    out_ += ':';
    fresh_ = true;
    return *this;
  }
  void text(std::string_view value) {
    comma();
    lcm_schema::append_json_string(value, out_);
  }
  void raw(const std::string& value) {
    comma();
    out_ += value;
  }
  void number(int64_t value) { raw(std::to_string(value)); }
  void number(double value) { raw(plain_number(value)); }

 private:
  void comma() {
    if (!fresh_) out_ += ',';
    fresh_ = false;
  }
  std::string& out_;
  bool fresh_ = true;
};

std::string hex(uint64_t value) { return "0x" + lcm_schema::fingerprint_text(value); }

void add_types(Json& json, const Model& model, const Channel& channel) {
  const auto& types = model.decoder().schema().structures();
  json.key("type");
  if (channel.type() < 0) {
    json.raw("null");
  } else {
    json.text(types[static_cast<std::size_t>(channel.type())].name);
  }
  json.key("fingerprint");
  if (channel.fingerprint == 0) {
    json.raw("null");
  } else {
    json.text(hex(channel.fingerprint));
  }
  json.key("candidates").open('[');
  for (const int type : channel.candidates) json.text(types[static_cast<std::size_t>(type)].name);
  json.close(']');
}

void add_channel(Json& json, const Model& model, int index, const Surroundings& around) {
  const Channel& channel = model.channels()[static_cast<std::size_t>(index)];
  const Rates rates = rates_of(channel, around);
  const Loss loss = model.loss(index);
  json.open('{');
  json.key("channel").text(channel.name);
  add_types(json, model, channel);
  json.key("count").number(channel.rate.count());
  json.key("hz").number(rates.hz);
  json.key("jitter_ms").number(rates.jitter_s * 1e3);
  json.key("bytes").number(channel.rate.bytes());
  json.key("bytes_per_s").number(rates.bytes_per_s);
  json.key("age_s").number(static_cast<double>(around.now_us - channel.rate.last_us()) * 1e-6);
  json.key("undecodable").number(channel.undecodable());
  json.key("untyped").number(channel.untyped);
  json.key("unknown_type").number(channel.unknown);
  json.key("damaged").number(channel.damaged);
  json.key("type_changes").number(channel.type_changes);
  if (!around.is_log) {
    json.key("lost").number(loss.count);
    json.key("lost_is_estimated").raw(loss.estimated ? "true" : "false");
  }
  json.key("last");
  lcm_schema::Tree tree;
  std::string last = "null";
  if (model.decode_last(index, tree)) {
    last.clear();
    lcm_schema::JsonOptions options;
    options.bytes_as_base64 = true;
    lcm_schema::append_json(tree, last, options);
  }
  json.raw(last);
  json.close('}');
}

void add_process(Json& json, const Process& process) {
  json.key("process").text(process.name.empty() ? "?" : process.name);
  json.key("pid").number(int64_t{process.pid});
}

void add_sender(Json& json, const Model& model, const Sender& sender, const Surroundings& around) {
  const auto found = around.publishers.find(sender.address);
  json.open('{');
  json.key("address").text(to_string(sender.address));
  add_process(json, found == around.publishers.end() ? Process() : found->second);
  json.key("messages").number(sender.messages);
  json.key("bytes").number(sender.bytes);
  json.key("lost").number(sender.lost());
  json.key("incomplete").number(sender.incomplete);
  json.key("doubled").number(sender.sequence.duplicates());
  json.key("channels").open('[');
  for (const Sender::Use& use : sender.uses) {
    const Loss loss = model.loss(sender, use);
    json.open('{');
    json.key("channel").text(model.channels()[static_cast<std::size_t>(use.channel)].name);
    json.key("count").number(use.count);
    json.key("lost").number(loss.count);
    json.key("lost_is_estimated").raw(loss.estimated ? "true" : "false");
    json.close('}');
  }
  json.close(']').close('}');
}

void add_network(Json& json, const Model& model, const Surroundings& around) {
  json.key("senders").open('[');
  for (const Sender& sender : model.senders()) {
    if (!sender.uses.empty()) add_sender(json, model, sender, around);
  }
  json.close(']').key("listeners").open('[');
  for (const Listener& listener : around.listeners) {
    json.open('{');
    add_process(json, listener.process);
    json.key("self").raw(listener.self ? "true" : "false");
    json.key("drops").number(listener.drops);
    json.close('}');
  }
  json.close(']').key("findings").open('[');
  for (const Finding& finding : around.findings) {
    json.open('{');
    json.key("text").text(finding.text);
    json.key("command").text(finding.command);
    json.close('}');
  }
  json.close(']');
}

}  // namespace

std::string json_report(const Model& model, const Surroundings& around) {
  std::string out;
  Json json(out);
  int64_t undecodable = 0;
  for (const Channel& channel : model.channels()) undecodable += channel.undecodable();
  json.open('{');
  json.key("source").text(around.source);
  json.key("duration_s").number(static_cast<double>(model.last_us() - model.first_us()) * 1e-6);
  json.key("received").number(model.messages());
  if (!around.is_log) json.key("lost").number(model.lost());
  json.key("undecodable").number(undecodable);
  json.key("foreign_datagrams").number(model.foreign());
  json.key("channels").open('[');
  for (const int index : visible_channels(model, View(), around))
    add_channel(json, model, index, around);
  json.close(']');
  if (!around.is_log) add_network(json, model, around);
  json.key("problems").open('[');
  for (const std::string& problem : around.problems) json.text(problem);
  json.close(']').close('}');
  return out;
}

}  // namespace marco::spy
