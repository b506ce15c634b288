#include "live/diagnosis/bus_survey.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "lcm_tools/diagnosis/host.hpp"
#include "lcm_tools/diagnosis/listening_socket.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/schema/built_in_sources.hpp"
#include "lcm_tools/schema/schema.hpp"
#include "lcm_tools/schema/wire.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/process_status_t.hpp"

namespace marco::diagnosis {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t kMaxChannels = 500;
constexpr std::size_t kMaxTroubles = 20;
constexpr int kBufferBytes = 1 << 20;
constexpr std::size_t kHeadBytes = 8192;  // of a datagram; a PROCESS_STATUS fits

double seconds_since(SteadyClock::time_point start) {
  return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

double listen(const ListeningSocket& socket,
              SurveyCounter& counter,
              double seconds,
              const std::atomic<bool>& stop) {
  const auto start = SteadyClock::now();
  std::array<uint8_t, kHeadBytes> bytes;
  while (!stop && seconds_since(start) < seconds) {
    pollfd wait = {socket.descriptor(), POLLIN, 0};
    if (::poll(&wait, 1, 50) <= 0) continue;
    sockaddr_in from = {};
    socklen_t size = sizeof from;
    const ssize_t length = ::recvfrom(socket.descriptor(), bytes.data(), bytes.size(), MSG_DONTWAIT,
                                      reinterpret_cast<sockaddr*>(&from), &size);
    if (length <= 0) continue;
    counter.add(process::wall_clock_us(), {ntohl(from.sin_addr.s_addr), ntohs(from.sin_port)},
                {bytes.data(), static_cast<std::size_t>(length)});
  }
  return seconds_since(start);
}

std::vector<Finding> look_for_the_reason(const UdpUrl& url,
                                         const std::string& program,
                                         int64_t heard) {
  Prober prober;
  NetworkState state = look_at_network(url, prober, heard);
  state.program = program;
  state.listeners = find_listeners(url.port, 0);
  for (Listener& listener : state.listeners) listener.self = listener.process.pid == ::getpid();
  return diagnose(state);
}

}  // namespace

std::optional<int64_t> stamp_at_head(std::span<const uint8_t> message) {
  if (message.size() < 16) return std::nullopt;
  return lcm_schema::load<int64_t>(message.data() + 8);
}

std::string type_name(uint64_t fingerprint) {
  static const lcm_schema::Schema kSchema(built_in_sources());
  const auto found = kSchema.with_fingerprint(fingerprint);
  return found.empty() ? "" : kSchema.structures()[static_cast<std::size_t>(found[0])].name;
}

void SurveyCounter::add(int64_t time_us, const Address& sender, std::span<const uint8_t> bytes) {
  const auto datagram = parse_datagram(bytes);
  // Of a large message the first fragment counts.
  if (!datagram || datagram->channel.empty() || datagram->channel == "LCM_SELF_TEST") return;
  const std::pair<std::string, Address> key(datagram->channel, sender);
  if (channels_.size() >= kMaxChannels && !channels_.contains(key)) return;
  HeardChannel& channel = channels_[key];
  ++channel.messages;
  channel.fingerprint = lcm_schema::fingerprint_of(datagram->payload).value_or(0);
  constexpr int64_t kYear2001Us = 1'000'000'000'000'000;
  const auto stamp_us = stamp_at_head(datagram->payload);
  channel.stamp_age_s.reset();
  if (stamp_us && *stamp_us > kYear2001Us && *stamp_us < 4 * kYear2001Us) {
    channel.stamp_age_s = static_cast<double>(time_us - *stamp_us) * 1e-6;
  }
  if (datagram->channel == channels::kProcessStatus) take_status(sender, datagram->payload);
}

void SurveyCounter::take_status(const Address& sender, std::span<const uint8_t> message) {
  process_status_t status;
  if (status.decode(message.data(), 0, static_cast<int>(message.size())) < 0) return;
  if (status.process == program_) {
    own_.insert(sender);
    return;
  }
  if (!status.state.starts_with(process::kNoDevice)) {
    troubles_.erase(status.process);
  } else if (troubles_.size() < kMaxTroubles) {
    troubles_[status.process] = status.state;
  }
}

BusSurvey SurveyCounter::result(double listened_s) const {
  BusSurvey survey;
  for (const auto& [key, channel] : channels_) {
    const auto& [name, sender] = key;
    if (own_.contains(sender)) continue;
    if (survey.channels.empty() || survey.channels.back().name != name) {
      survey.channels.push_back(channel);
      survey.channels.back().name = name;
    } else {
      survey.channels.back().messages += channel.messages;
    }
    HeardChannel& heard = survey.channels.back();
    heard.hz = static_cast<double>(heard.messages) / listened_s;
  }
  survey.troubles = troubles_;
  return survey;
}

BusSurvey survey_bus(const UdpUrl& url,
                     const std::string& program,
                     double seconds,
                     const std::atomic<bool>& stop) {
  SurveyCounter counter(program);
  BusSurvey survey;
  try {
    const ListeningSocket socket(url, kBufferBytes);
    std::string error;
    double listened_s = seconds;
    if (socket.join(error)) listened_s = listen(socket, counter, seconds, stop);
    survey = counter.result(std::max(0.1, listened_s));
  } catch (const std::runtime_error&) {
    // The port is taken: reported below.
  }
  int64_t heard = 0;
  for (const HeardChannel& channel : survey.channels) heard += channel.messages;
  if (!stop) survey.network = look_for_the_reason(url, program, heard);
  return survey;
}

}  // namespace marco::diagnosis
