#include "lcm_tools/procman/process/deputy_watch.hpp"

#include <algorithm>
#include <utility>

#include "lcm_tools/procman/process/lone_deputy.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kPatienceUs = 3'000'000;
constexpr int64_t kSilentUs = 5'000'000;
constexpr std::size_t kMostOlder = 20;

/// The host in PMD_INFO2 and PMD_INFO: after fingerprint and utime, a string. "" when it is none.
std::string host_of(const process::RawMessage& raw) {
  constexpr std::size_t kLengthAt = 16;
  constexpr std::size_t kTextAt = 20;
  if (raw.bytes.size() < kTextAt) return "";
  std::size_t length = 0;
  for (std::size_t i = kLengthAt; i < kTextAt; ++i) length = length * 256 + raw.bytes[i];
  if (length < 2 || length > 200 || raw.bytes.size() - kTextAt < length) return "";
  const auto text = raw.bytes.subspan(kTextAt, length - 1);
  return {text.begin(), text.end()};
}

}  // namespace

DeputyWatch::DeputyWatch(process::Bus& bus, int64_t now_us) : began_us_(now_us) {
  bus.subscribe_raw("PMD_INFO2?", [this](const process::RawMessage& raw) {
    const std::string host = host_of(raw);
    if (host.empty() || older_.size() >= kMostOlder || !older_.insert(host).second) return;
    events_.push_back("deputy " + host + " uses libbot2's protocol (" + std::string(raw.channel) +
                      "), not ours: only bot-procman-sheriff can control it. Start there: "
                      "marco-procman-deputy -i " +
                      host + " --script FILE");
  });
}

std::vector<std::string> DeputyWatch::step_to(int64_t now_us, const SheriffState& sheriff) {
  if (now_us - began_us_ >= kPatienceUs) look_for_missing(sheriff);
  look_for_silent(now_us, sheriff);
  return std::exchange(events_, {});
}

void DeputyWatch::look_for_missing(const SheriffState& sheriff) {
  std::string heard;
  for (const auto& [id, deputy] : sheriff.deputies()) {
    if (heard.size() < 200) heard += (heard.empty() ? "" : ", ") + id;
  }
  for (const auto& [id, command] : sheriff.commands()) {
    if (sheriff.deputies().contains(command.deputy)) continue;
    if (!missing_.insert(command.deputy).second) continue;
    std::string event = "deputy " + command.deputy + " was silent for 3 s (" +
                        (heard.empty() ? "as was every other" : "active: " + heard) +
                        "). Start it on its host: marco-procman-deputy -i " + command.deputy +
                        " --script FILE";
    if (command.deputy == kLoneDeputyId) event += "; or give this sheriff one with -l";
    events_.push_back(std::move(event));
  }
}

void DeputyWatch::look_for_silent(int64_t now_us, const SheriffState& sheriff) {
  for (const auto& [id, deputy] : sheriff.deputies()) {
    const bool is_silent = now_us - deputy.heard_us > kSilentUs;
    if (is_silent && silent_.insert(id).second) {
      events_.push_back("deputy " + id + " has been silent for 5 s; its commands keep running");
    } else if (!is_silent && silent_.erase(id) > 0) {
      events_.push_back("deputy " + id + " is back");
    }
  }
}

}  // namespace marco::procman
