#include "lcm_tools/relay/tcp_link.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/relay/channel_rule.hpp"

namespace marco::relay {
namespace {

Role other_of(Role role) { return role == Role::server ? Role::client : Role::server; }

}  // namespace

TcpLink::TcpLink(TcpSocket socket,
                 Role own_role,
                 const std::string& expression,
                 std::size_t most_bytes)
    : socket_(std::move(socket)),
      own_role_(own_role),
      reader_(other_of(own_role)),
      outbox_(most_bytes),
      outgoing_(greeting_of(own_role)) {
  if (own_role == Role::client) append_subscribe(outgoing_, expression);
}

void TcpLink::read(const std::function<void(const Frame&)>& on_message) {
  constexpr int kReadsInARow = 16;  // the other connections want their turn, too
  std::array<uint8_t, 1 << 16> bytes{};
  for (int i = 0; i < kReadsInARow; ++i) {
    const std::size_t got = socket_.read(bytes);
    if (got == 0) return;
    reader_.add(std::span(bytes).first(got));
    while (const auto frame = reader_.next()) {
      if (frame->kind == Frame::Kind::publish) on_message(*frame);
      if (frame->kind == Frame::Kind::subscribe) subscribe(frame->channel);
      if (frame->kind == Frame::Kind::unsubscribe) wanted_.erase(frame->channel);
    }
  }
}

// @throws std::invalid_argument for an expression that is none.
void TcpLink::subscribe(const std::string& expression) {
  constexpr std::size_t kMostExpressions = 256;
  require(wanted_.size() < kMostExpressions, "it subscribes to more than 256 expressions");
  wanted_.try_emplace(expression, pattern_of(expression));
}

bool TcpLink::is_wanted(const std::string& channel) const {
  return own_role_ == Role::client ||
         std::any_of(wanted_.begin(), wanted_.end(),
                     [&](const auto& wanted) { return wanted.second.matches(channel); });
}

void TcpLink::write() {
  constexpr std::size_t kAtOnce = 1 << 16;
  while (has_to_write()) {
    while (outgoing_.size() < kAtOnce && !outbox_.empty()) {
      const auto message = outbox_.take();
      append_publish(outgoing_, message->channel, message->data);
    }
    const std::size_t wrote = socket_.write(std::span<const char>(outgoing_).subspan(sent_));
    sent_ += wrote;
    if (sent_ < outgoing_.size()) return;
    outgoing_.clear();
    sent_ = 0;
  }
}

bool TcpLink::send(const std::string& channel,
                   std::span<const uint8_t> data,
                   std::map<std::string, int64_t>& lost) {
  if (!is_greeted() || !is_wanted(channel)) return false;
  for (const std::string& dropped : outbox_.add(channel, data)) ++lost[dropped];
  return true;
}

}  // namespace marco::relay
