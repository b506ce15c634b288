#include "live/diagnosis/silence_text.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <regex>

#include "lcm_tools/base/format.hpp"
#include "lcm_tools/files/channel_pattern.hpp"
#include "recordings/foreign.hpp"

namespace marco::diagnosis {
namespace {

constexpr std::size_t kNamed = 6;      // channels in one line
constexpr double kOtherClockS = 60.0;  // stamps this far from ours

std::string short_number(double value) { return format("%.3g", value); }

std::string type_text(uint64_t fingerprint) {
  if (fingerprint == 0) return "no LCM type";
  const std::string name = type_name(fingerprint);
  return name.empty() ? "an unknown type, fingerprint " + lcm_schema::fingerprint_text(fingerprint)
                      : name;
}

std::string span_text(double seconds) {
  seconds = std::abs(seconds);
  if (seconds < 120.0) return short_number(seconds) + " s";
  if (seconds < 7200.0) return short_number(seconds / 60.0) + " min";
  if (seconds < 172800.0) return short_number(seconds / 3600.0) + " h";
  return short_number(seconds / 86400.0) + " days";
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string unused_text(const Lack& lack) {
  std::string text = "messages come on " + lack.channel + " (" + lack.expected.what + ") at " +
                     short_number(lack.hz) + " Hz, but all are dropped: " + lack.cause + ".";
  if (lack.cause.starts_with("no SENSOR_INFO")) {
    text +=
        " SENSOR_INFO gives the pose of the sensor; its driver must send it once a second, as "
        "Marco's drivers do.";
  }
  return text;
}

std::string lack_text(const Lack& lack) {
  const Expectation& expected = lack.expected;
  const std::string instead = expected.without.empty() ? "" : " " + expected.without + ".";
  const std::string remedy = expected.remedy.empty() ? "" : " " + expected.remedy;
  switch (lack.kind) {
    case Lack::Kind::never:
      return (instead.empty() ? "waiting for " : "no ") + expected.what + ": nothing on " +
             expected.channels + " for " + short_number(std::floor(lack.silent_s)) + " s." +
             instead + remedy;
    case Lack::Kind::ended:
      return "no more messages on " + lack.channel + " (" + expected.what + "): the last came " +
             short_number(std::floor(lack.silent_s)) + " s ago, " + short_number(lack.hz) +
             " Hz before." + instead;
    case Lack::Kind::wrong_type:
      return "waiting for " + expected.what + ": " + lack.channel + " carries " +
             type_text(lack.fingerprint) + ", not " + joined(expected.types, " or ") + "." +
             instead;
    case Lack::Kind::unused:
      return unused_text(lack) + instead;
    case Lack::Kind::clock:
      return "messages on " + lack.channel + " (" + expected.what +
             ") are not used: their stamps are " + span_text(lack.ahead_s) +
             (lack.ahead_s > 0 ? " ahead of" : " behind") + " the scans'." + instead +
             " Do their hosts use the same time server?";
    case Lack::Kind::two_poses:
      return "SENSOR_INFO alternates between two poses of " + lack.channel + ": " + lack.cause +
             " (mount: position, quaternion). Probably two drivers are running, or two robots "
             "share this bus.";
  }
  return {};
}

bool is_expected(const std::vector<Lack>& lacks, const std::string& channel) {
  return std::any_of(lacks.begin(), lacks.end(), [&](const Lack& lack) {
    return !lack.expected.pattern.empty() && ChannelPattern(lack.expected.pattern).matches(channel);
  });
}

std::string bus_text(const BusSurvey& survey) {
  std::vector<std::string> named;
  for (const HeardChannel& channel : survey.channels) {
    if (named.size() == kNamed) break;
    const std::string type = type_name(channel.fingerprint);
    named.push_back(
        channel.name + " " + short_number(channel.hz) + " Hz (" +
        (type.empty() ? "fingerprint " + lcm_schema::fingerprint_text(channel.fingerprint) : type) +
        ")");
  }
  if (named.empty()) return {};
  std::string text = "On this bus: " + joined(named, ", ");
  if (survey.channels.size() > named.size()) {
    text += " and " + std::to_string(survey.channels.size() - named.size()) + " more";
  }
  const auto off = std::find_if(
      survey.channels.begin(), survey.channels.end(),
      [](const auto& one) { return one.stamp_age_s && std::abs(*one.stamp_age_s) > kOtherClockS; });
  if (off != survey.channels.end()) {
    text += "; stamps on " + off->name + " are " + span_text(*off->stamp_age_s) +
            (*off->stamp_age_s > 0 ? " old (a replayed log, or a wrong clock)"
                                   : " in the future (a wrong clock)");
  }
  return text + ".";
}

// A channel of another system, as ForeignTable knows it.
bool is_foreign(const Lack& lack, const HeardChannel& heard) {
  static const ForeignTable kTable;
  if (lack.expected.meaning.empty()) return false;
  return std::any_of(kTable.channels.begin(), kTable.channels.end(), [&](const auto& entry) {
    return entry.meaning == lack.expected.meaning &&
           entry.fingerprint == lcm_schema::fingerprint_text(heard.fingerprint) &&
           ChannelPattern(entry.channel).matches(heard.name);
  });
}

// "lidar" and "LIDAR", "RPLIDAR" and "LIDAR_1"
bool is_near(const std::string& name, const std::string& channels) {
  const std::string wanted = lower(channels.substr(0, channels.find(' ')));
  const std::string heard = lower(name);
  return wanted.size() >= 3 && (heard.find(wanted) != std::string::npos ||
                                (heard.size() >= 3 && wanted.find(heard) != std::string::npos));
}

std::string near_text(const Lack& lack, const HeardChannel& heard) {
  const Expectation& expected = lack.expected;
  const std::string type = type_name(heard.fingerprint);
  const bool fits =
      std::find(expected.types.begin(), expected.types.end(), type) != expected.types.end();
  if (fits || is_foreign(lack, heard)) {
    std::string advice = "rename it to " + expected.channels + " in its sender";
    if (!fits) {
      advice += " and send " + joined(expected.types, " or ") +
                ", or record it with lcm-logger and give the log to `marco map`";
    }
    return heard.name + " carries " + expected.what + " under another name: " + advice + ".";
  }
  if (is_near(heard.name, expected.channels)) {
    return heard.name + " has a similar name, but carries " + type_text(heard.fingerprint) + ".";
  }
  return {};
}

}  // namespace

std::string silence_text(const std::vector<Lack>& lacks, const BusSurvey& survey) {
  std::vector<std::string> lines;
  lines.reserve(lacks.size() + 1);
  for (const Lack& lack : lacks) lines.push_back(lack_text(lack));
  if (const std::string bus = bus_text(survey); !bus.empty()) lines.push_back(bus);
  std::vector<std::string> hints;
  hints.reserve(survey.troubles.size());
  for (const auto& [process, state] : survey.troubles) {
    hints.emplace_back(process).append(": ").append(state);
  }
  for (const Lack& lack : lacks) {
    if (lack.kind != Lack::Kind::never) continue;
    for (const HeardChannel& heard : survey.channels) {
      if (is_expected(lacks, heard.name) || hints.size() > kNamed) continue;
      if (std::string hint = near_text(lack, heard); !hint.empty()) hints.push_back(hint);
    }
  }
  for (const Finding& finding : survey.network) {
    hints.push_back(finding.text + (finding.command.empty() ? "" : ": " + finding.command));
  }
  lines.insert(lines.end(), hints.begin(), hints.end());
  return joined(lines, "\n  ");
}

std::string situation(const std::vector<Lack>& lacks, const BusSurvey& survey) {
  std::string text;
  for (const Lack& lack : lacks) {
    text += lack.expected.what + "/" + std::to_string(static_cast<int>(lack.kind)) + "/" +
            lack.cause + "/" + lcm_schema::fingerprint_text(lack.fingerprint) + "\n";
  }
  for (const HeardChannel& heard : survey.channels) {
    text += heard.name + " " + lcm_schema::fingerprint_text(heard.fingerprint) + "\n";
  }
  for (const auto& [process, state] : survey.troubles)
    (text += process).append(": ").append(state).append("\n");
  for (const Finding& finding : survey.network) text += finding.text + "\n";
  return std::regex_replace(text, std::regex("[0-9]+ (datagrams|bytes)"), "$1");
}

std::string short_state(const Lack& lack) {
  switch (lack.kind) {
    case Lack::Kind::never:
    case Lack::Kind::wrong_type:
      return (lack.expected.without.empty() ? "waiting for " : "no ") + lack.expected.what;
    case Lack::Kind::ended:
      return "no more messages on " + lack.channel;
    case Lack::Kind::unused:
      return "all messages on " + lack.channel + " are dropped: " + lack.cause;
    case Lack::Kind::clock:
      return "the stamps on " + lack.channel + " do not fit the scans'";
    case Lack::Kind::two_poses:
      return "SENSOR_INFO has two poses of " + lack.channel;
  }
  return {};
}

}  // namespace marco::diagnosis
