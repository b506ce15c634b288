#include "tools/log/describe_recording.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <variant>
#include <vector>

#include "lcm_tools/base/format.hpp"
#include "lcm_tools/files/readable.hpp"
#include "lcm_tools/log/moment.hpp"
#include "recordings/recording.hpp"
#include "recordings/ros/open_messages.hpp"
#include "recordings/ros/ros_survey.hpp"

namespace marco::logs {
namespace {

using Json = nlohmann::ordered_json;

struct Seen {
  std::string name, type, encoding;
  int64_t count = 0;
  Utime first, last;

  void add(Utime now) {
    first = count == 0 ? now : std::min(first, now);
    last = count == 0 ? now : std::max(last, now);
    ++count;
  }
  double rate_hz() const {
    const double span_s = (last - first).seconds();
    return span_s > 0.0 ? static_cast<double>(count - 1) / span_s : 0.0;
  }
};

struct Contents {
  std::string format;
  std::vector<Seen> topics;
  std::vector<std::string> notes;
};

std::string damage_text(const ros::Damage& damage) {
  return format("damage    %lld bytes at %lld places%s", static_cast<long long>(damage.bytes),
                static_cast<long long>(damage.places),
                damage.is_cut_off ? ", and the file is cut off" : "");
}

void add_clocks(const ros::RosSurvey& survey, Contents& contents) {
  for (const auto& [name, topic] : survey.topics) {
    if (topic.undecodable > 0) {
      contents.notes.push_back(format("undecoded %s: %lld messages do not fit %s", name.c_str(),
                                      static_cast<long long>(topic.undecodable),
                                      topic.type.c_str()));
    }
    if (topic.delays.empty()) continue;
    const double late_s = topic.delays.least_s();
    contents.notes.push_back(format("clock     %s is recorded %.3f s %s its stamps", name.c_str(),
                                    std::abs(late_s), late_s < 0.0 ? "before" : "after"));
  }
}

Contents contents_of_ros(const std::string& path) {
  const auto source = ros::open_messages(path);
  Contents contents;
  contents.format = source->format();
  std::map<const ros::Topic*, Seen> seen;
  while (const auto message = source->next()) {
    seen[message->topic].add(Utime::from_us(message->received_ns / 1000));
  }
  // Publishers of one topic apart, as the recording has them; topics without a message, too.
  for (const ros::Topic* topic : source->topics()) {
    Seen& row = seen[topic];
    row.name = topic->name;
    row.type = topic->type;
    row.encoding = topic->encoding;
    contents.topics.push_back(row);
  }
  contents.notes = source->notes();
  const ros::Damage damage = source->damage();
  if (damage.places > 0 || damage.is_cut_off) contents.notes.push_back(damage_text(damage));
  add_clocks(ros::survey(*source), contents);
  return contents;
}

std::optional<Contents> contents_of_others(const std::string& path) {
  const auto recording = open_recording(path);
  constexpr const char* kKinds[] = {"sensor info", "scan",     "odometry",
                                    "imu",         "pan-tilt", "true pose"};
  static_assert(std::size(kKinds) == std::variant_size_v<Sample>);
  std::map<std::size_t, Seen> kinds;
  while (const auto sample = recording->next()) {
    kinds[sample->index()].add(std::visit([](const auto& value) { return value.utime; }, *sample));
  }
  const files::InputReport& report = recording->report();
  if (report.format == "LCM log") return std::nullopt;
  Contents contents{report.format, {}, report.notes};
  for (auto& [index, seen] : kinds) {
    seen.name = kKinds[index];
    contents.topics.push_back(std::move(seen));
  }
  for (const auto& [cause, count] : report.dropped) {
    contents.notes.push_back(
        format("left out  %lld: %s", static_cast<long long>(count), cause.c_str()));
  }
  return contents;
}

// LCM's mark of an event, at the start of every whole log.
bool is_lcm_log(const std::string& path) {
  return files::first_bytes(path, 1 << 16).find("\xED\xA1\xDA\x01") != std::string::npos;
}

std::optional<Contents> contents_of(const std::string& path) {
  if (ros::is_message_recording(path)) return contents_of_ros(path);
  if (is_lcm_log(path) || !is_recording(path)) return std::nullopt;
  return contents_of_others(path);
}

Seen whole_of(const Contents& contents) {
  Seen whole;
  for (const Seen& topic : contents.topics) {
    if (topic.count == 0) continue;
    whole.add(topic.first);
    whole.add(topic.last);
  }
  whole.count = 0;
  for (const Seen& topic : contents.topics) whole.count += topic.count;
  return whole;
}

std::string text_of(const Contents& contents, const std::string& path) {
  const Seen whole = whole_of(contents);
  std::string text =
      format("%s: %s, %lld messages of %zu topics, %.3f s\n  from %s\n  to   %s\n", path.c_str(),
             contents.format.c_str(), static_cast<long long>(whole.count), contents.topics.size(),
             (whole.last - whole.first).seconds(), to_text(whole.first).c_str(),
             to_text(whole.last).c_str());
  text += format("%-34s %-36s %-8s %9s %9s\n", "topic", "type", "encoding", "messages", "Hz");
  for (const Seen& topic : contents.topics) {
    text += format("%-34s %-36s %-8s %9lld %9.2f\n", topic.name.c_str(), topic.type.c_str(),
                   topic.encoding.c_str(), static_cast<long long>(topic.count), topic.rate_hz());
  }
  if (!contents.notes.empty()) text += "to know:\n";
  for (const std::string& note : contents.notes) text += "  " + note + "\n";
  return text;
}

std::string json_of(const Contents& contents, const std::string& path) {
  const Seen whole = whole_of(contents);
  Json topics = Json::array();
  for (const Seen& topic : contents.topics) {
    topics.push_back({{"topic", topic.name},
                      {"type", topic.type},
                      {"encoding", topic.encoding},
                      {"messages", topic.count},
                      {"rate_hz", topic.rate_hz()}});
  }
  const Json all{{"recording", path},           {"format", contents.format},
                 {"messages", whole.count},     {"first_utime", whole.first.us},
                 {"last_utime", whole.last.us}, {"topics", topics},
                 {"notes", contents.notes}};
  return all.dump(2) + "\n";
}

}  // namespace

std::optional<std::string> describe_recording(const std::string& path, Format format) {
  const auto contents = contents_of(path);
  if (!contents) return std::nullopt;
  return format == Format::json ? json_of(*contents, path) : text_of(*contents, path);
}

}  // namespace marco::logs
