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

// Memory per message besides its bytes; otherwise millions of empty ones would be free.
std::size_t Outbox::cost(const Message& message) {
  constexpr std::size_t kBookkeeping = 128;
  return message.data.size() + kBookkeeping;
}

std::vector<std::string> Outbox::add(std::string channel, std::span<const uint8_t> data) {
  messages_.push_back({std::move(channel), {data.begin(), data.end()}});
  bytes_ += cost(messages_.back());
  bytes_by_channel_[messages_.back().channel] += cost(messages_.back());
  std::vector<std::string> dropped;
  while (bytes_ > most_bytes_) dropped.push_back(drop_one());
  return dropped;
}

std::string Outbox::drop_one() {
  const auto largest =
      std::max_element(bytes_by_channel_.begin(), bytes_by_channel_.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto oldest = std::find_if(messages_.begin(), messages_.end(), [&](const auto& message) {
    return message.channel == largest->first;
  });
  const Message message = std::move(*oldest);
  messages_.erase(oldest);
  forget(message);
  return message.channel;
}

void Outbox::forget(const Message& message) {
  bytes_ -= cost(message);
  const auto channel = bytes_by_channel_.find(message.channel);
  channel->second -= cost(message);
  if (channel->second == 0) bytes_by_channel_.erase(channel);
}

std::optional<Outbox::Message> Outbox::take() {
  if (messages_.empty()) return std::nullopt;
  Message first = std::move(messages_.front());
  messages_.pop_front();
  forget(first);
  return first;
}

std::map<std::string, int64_t> Outbox::clear() {
  std::map<std::string, int64_t> counts;
  for (const Message& message : messages_) ++counts[message.channel];
  messages_.clear();
  bytes_by_channel_.clear();
  bytes_ = 0;
  return counts;
}

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
