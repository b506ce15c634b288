#include "web/health.hpp"

#include <algorithm>
#include <cmath>

#include "common/robot_values.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "web/foxglove/json.hpp"

namespace marco::web {
namespace {

using foxglove::number;
using foxglove::text_json;

constexpr int64_t kSecondUs = 1'000'000;
constexpr int64_t kSilentUs = 5 * kSecondUs;       // each says how it is once a second
constexpr int64_t kBusyUs = 60 * kSecondUs;        // the same, of one that announced long work
constexpr int64_t kForgottenUs = 600 * kSecondUs;  // a program that was ended long ago
constexpr int64_t kDroppedLatelyUs = 10 * kSecondUs;
constexpr std::size_t kMostPrograms = 200;  // anybody may make some up
constexpr double kOtherClockS = 60.0;

bool waits(const std::string& state) {
  return state.starts_with("waiting for") || state.starts_with("no more messages") ||
         state.starts_with("no ");
}

double seconds(int64_t us) { return std::round(static_cast<double>(us) / 1e4) / 100.0; }

template <class List, class Each>
std::string list_json(const List& list, Each each) {
  std::string json = "[";
  for (const auto& item : list) json += (json.size() == 1 ? "" : ",") + each(item);
  return json + "]";
}

}  // namespace

void Health::take_status(const std::string& program,
                         const std::string& state,
                         int64_t dropped,
                         int64_t now_us) {
  std::erase_if(programs_,
                [&](const auto& one) { return now_us - one.second.heard_us > kForgottenUs; });
  if (programs_.size() >= kMostPrograms && !programs_.contains(program)) return;
  const auto [at, is_new] = programs_.try_emplace(program);
  Program& known = at->second;
  if (!is_new && dropped > known.dropped) known.dropped_us = now_us;
  known.dropped = dropped;
  known.state = state;
  known.heard_us = now_us;
}

void Health::take_base(const std::string& base,
                       bool is_link_up,
                       const std::vector<double>& battery_v,
                       const std::string& note,
                       int64_t now_us) {
  const BaseNote words(note);
  base_ = Base{base, words.text, words.guard, is_link_up, battery_v, now_us};
}

void Health::take_pose_age(double age_s, int64_t now_us) {
  if (!(std::abs(age_s) < kOtherClockS)) return;
  // The worst of a second or so is what a person feels.
  const bool is_old = now_us - latency_us_ > kSecondUs;
  if (is_old || age_s >= latency_s_) {
    latency_s_ = age_s;
    latency_us_ = now_us;
  }
}

std::string Health::word_of(const Program& program, int64_t now_us) const {
  const bool is_busy = program.state.starts_with(process::kBusy);
  if (now_us - program.heard_us > (is_busy ? kBusyUs : kSilentUs)) return "silent";
  if (program.state.starts_with(process::kNoDevice)) return "error";
  const bool drops = program.dropped_us != 0 && now_us - program.dropped_us < kDroppedLatelyUs;
  return drops || waits(program.state) ? "warning" : "ok";
}

std::vector<HealthFinding> Health::own_findings(int64_t now_us) const {
  std::vector<HealthFinding> findings;
  for (const auto& [name, program] : programs_) {
    const std::string word = word_of(program, now_us);
    if (word == "silent") {
      findings.push_back({true, name + " is silent",
                          "It ended, or its host is unreachable. Read its output, and start it "
                          "again."});
    } else if (word == "error") {
      findings.push_back({true, name + ": " + program.state,
                          "Is the device on, its cable plugged in, and its name in the script "
                          "right?"});
    }
  }
  if (base_ && now_us - base_->heard_us < kSilentUs && !base_->is_link_up) {
    findings.push_back({true,
                        "the base " + base_->name + " does not answer" +
                            (base_->note.empty() ? "" : ": " + base_->note),
                        "Is it switched on, and its cable plugged in?"});
  }
  if (base_ && now_us - base_->heard_us < kSilentUs && !base_->guard.empty()) {
    findings.push_back({false, "the obstacle guard of " + base_->name + ": " + base_->guard,
                        "It needs a running laser, and its height in the driver's position_m: see "
                        "docs/stopping.md."});
  }
  return findings;
}

std::string Health::json(const Surroundings& around, int64_t utime_us, int64_t now_us) const {
  std::vector<HealthFinding> findings = own_findings(now_us);
  findings.insert(findings.end(), around.findings.begin(), around.findings.end());
  std::stable_partition(findings.begin(), findings.end(),
                        [](const HealthFinding& finding) { return finding.is_error; });
  std::string json = R"({"utime":)" + std::to_string(utime_us) + R"(,"programs":)";
  json += list_json(programs_, [&](const auto& one) {
    const auto& [name, program] = one;
    return R"({"name":)" + text_json(name) + R"(,"state":")" + word_of(program, now_us) +
           R"(","text":)" + text_json(program.state) + R"(,"age_s":)" +
           number(seconds(now_us - program.heard_us)) + "}";
  });
  json += R"(,"channels":)" + list_json(around.channels, [](const ChannelHealth& channel) {
            return R"({"name":)" + text_json(channel.name) + R"(,"type":)" +
                   text_json(channel.type) + R"(,"hz":)" +
                   number(std::round(100.0 * channel.hz) / 100.0) + R"(,"lost":)" +
                   std::to_string(channel.lost) + R"(,"age_s":)" +
                   number(std::round(100.0 * channel.age_s) / 100.0) + "}";
          });
  json += R"(,"findings":)" + list_json(findings, [](const HealthFinding& finding) {
            return std::string(R"({"severity":")") + (finding.is_error ? "error" : "warning") +
                   R"(","text":)" + text_json(finding.text) + R"(,"remedy":)" +
                   text_json(finding.remedy) + "}";
          });
  const bool has_base = base_ && now_us - base_->heard_us < kSilentUs;
  json += R"(,"battery_v":)" + list_json(has_base ? base_->battery_v : std::vector<double>(),
                                         [](double volt) { return number(volt); });
  const bool has_latency = latency_us_ != 0 && now_us - latency_us_ < kSilentUs;
  json += R"(,"latency_ms":)" +
          (has_latency ? number(std::round(1e4 * latency_s_) / 10.0) : std::string("null"));
  return json + R"(,"clients":)" + std::to_string(around.clients) + R"(,"refused":)" +
         std::to_string(around.refused) + R"(,"dropped":)" + std::to_string(around.dropped) + "}";
}

}  // namespace marco::web
