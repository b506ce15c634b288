#include "drivers/p2os/session.hpp"

namespace marco::drivers::p2os {
namespace {

constexpr double kSyncS = 0.5;
constexpr double kPulseS = 0.4;
constexpr double kSilentS = 1.5;

}  // namespace

void Session::on_connection(bool connected, Utime now) {
  connected_ = connected;
  parser_.clear();
  to_send_.clear();
  speed_due_ = heard_ ? search_.current() : search_.next();
  restart(now);
}

void Session::restart(Utime now) {
  sync_ = 0;
  next_sync_ = last_packet_ = now;
}

std::vector<Bytes> Session::receive(std::span<const uint8_t> bytes, Utime now) {
  std::vector<Bytes> payloads;
  parser_.push(bytes);
  while (auto payload = parser_.next()) {
    last_packet_ = now;
    heard_ = true;
    payloads.push_back(std::move(*payload));
  }
  return payloads;
}

bool Session::on_sync(const Bytes& payload, Utime now) {
  if (decode_sip(payload)) {
    // Still open from an earlier client: close it and begin again.
    say(CommandId::close);
    next_sync_ = now + Duration::from_seconds(0.2);
    sync_ = 0;
    return false;
  }
  if (payload[0] != sync_) {
    restart(now);
    next_sync_ = now + Duration::from_seconds(kSyncS);
    return false;
  }
  if (sync_ < 2) {
    ++sync_;
    next_sync_ = now;
    return false;
  }
  const auto name = decode_name(payload);
  if (!name) {
    reject();
    return false;
  }
  name_ = *name;
  sync_ = 3;
  return true;
}

void Session::say(CommandId id, std::optional<int> value) { send(encode_command({id, value, ""})); }

bool Session::advance(Utime now) {
  if (!connected_) return true;
  if (!is_open() && now >= next_sync_) {
    next_sync_ = now + Duration::from_seconds(kSyncS);
    say(static_cast<CommandId>(sync_));
  }
  if ((now - last_packet_).seconds() > kSilentS) {
    if (!heard_) {
      parser_.clear();
      speed_due_ = search_.next();
    }
    return false;
  }
  if (is_open() && to_send_.empty() && (now - last_sent_).seconds() > kPulseS)
    say(CommandId::pulse);
  return true;
}

void Session::flush(Utime now, std::vector<uint8_t>& out) {
  if (connected_ && !to_send_.empty()) {
    out.insert(out.end(), to_send_.begin(), to_send_.end());
    last_sent_ = now;
  }
  to_send_.clear();
}

void Session::shut_down(std::vector<uint8_t>& out) {
  to_send_.clear();
  say(CommandId::stop);
  say(CommandId::enable, 0);
  say(CommandId::close);
  out.insert(out.end(), to_send_.begin(), to_send_.end());
  to_send_.clear();
}

}  // namespace marco::drivers::p2os
