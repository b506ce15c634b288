#include "lcm_tools/spy/model.hpp"

#include <algorithm>

namespace marco::spy {
namespace {

constexpr std::size_t kMaxChannels = 4000;
constexpr std::size_t kMaxSenders = 4000;
constexpr int64_t kFragmentPatienceUs = 500000;
constexpr int64_t kHistoryStepUs = 25000;
constexpr std::size_t kHistoryCount = 1200;
constexpr std::size_t kHistoryBytes = 2U << 20U;
constexpr std::size_t kTiledHistoryBytes = 24U << 20U;

bool comes_in_tiles(const lcm_schema::Structure& type) {
  return std::any_of(type.members.begin(), type.members.end(),
                     [](const lcm_schema::Member& member) { return member.name == "revision"; });
}

}  // namespace

int Model::find(std::string_view channel) const {
  const auto found = channel_of_name_.find(channel);
  return found == channel_of_name_.end() ? -1 : found->second;
}

int Model::channel_index(std::string_view name) {
  const int known = find(name);
  if (known >= 0 || channels_.size() >= kMaxChannels) return known;
  const int index = static_cast<int>(channels_.size());
  channels_.emplace_back();
  channels_.back().name = name;
  channel_of_name_.emplace(name, index);
  return index;
}

int Model::sender_index(const Address& address) {
  const auto found = sender_of_address_.find(address);
  if (found != sender_of_address_.end()) return found->second;
  if (senders_.size() >= kMaxSenders) return -1;
  const int index = static_cast<int>(senders_.size());
  senders_.emplace_back();
  senders_.back().address = address;
  sender_of_address_.emplace(address, index);
  return index;
}

Sender::Use& Model::use_of(Sender& sender, int channel) {
  for (Sender::Use& use : sender.uses) {
    if (use.channel == channel) return use;
  }
  sender.uses.push_back({channel, 0, 0});
  return sender.uses.back();
}

void Model::add_datagram(int64_t time_us, const Address& address, std::span<const uint8_t> bytes) {
  const auto datagram = diagnosis::parse_datagram(bytes);
  if (!datagram) {
    ++foreign_;
    return;
  }
  const int index = sender_index(address);
  if (index < 0) {
    ++ignored_;
    return;
  }
  Sender& sender = senders_[static_cast<std::size_t>(index)];
  sender.last_us = time_us;
  const auto deliver = [&](std::string_view name, std::span<const uint8_t> message) {
    const int channel = channel_index(name);
    if (channel < 0) {
      ++ignored_;
      return;
    }
    ++sender.messages;
    sender.bytes += static_cast<int64_t>(message.size());
    ++use_of(sender, channel).count;
    add_to_channel(time_us, channel, message);
  };
  if (!datagram->fragmented) {
    if (sender.sequence.add(datagram->sequence)) deliver(datagram->channel, datagram->payload);
    return;
  }
  // All fragments of a message bear its number; one of a message already complete is a double.
  if (!sender.sequence.add_fragment(datagram->sequence) &&
      !sender.fragments.holds(datagram->sequence)) {
    return;
  }
  std::vector<std::string> incomplete;
  if (const auto message = sender.fragments.add(*datagram, time_us, incomplete)) {
    deliver(message->channel, message->bytes());
  }
  count_incomplete(sender, incomplete);
}

void Model::settle(int64_t now_us) {
  std::vector<std::string> incomplete;
  for (Sender& sender : senders_) {
    if (sender.fragments.empty()) continue;
    incomplete.clear();
    sender.fragments.give_up(now_us - kFragmentPatienceUs, incomplete);
    count_incomplete(sender, incomplete);
  }
}

void Model::count_incomplete(Sender& sender, const std::vector<std::string>& channels) {
  for (const std::string& name : channels) {
    ++sender.incomplete;
    const int channel = name.empty() ? -1 : channel_index(name);
    if (channel < 0) {
      ++sender.incomplete_unknown;
    } else {
      ++use_of(sender, channel).incomplete;
    }
  }
}

void Model::add_message(int64_t time_us, std::string_view name, std::span<const uint8_t> bytes) {
  const int channel = channel_index(name);
  if (channel < 0) {
    ++ignored_;
  } else {
    add_to_channel(time_us, channel, bytes);
  }
}

void Model::add_to_channel(int64_t time_us, int index, std::span<const uint8_t> bytes) {
  Channel& channel = channels_[static_cast<std::size_t>(index)];
  time_us = std::clamp<int64_t>(time_us, 0, kMaxTimeUs);
  if (messages_++ == 0) first_us_ = time_us;
  last_us_ = std::max(last_us_, time_us);
  channel.rate.add(time_us, bytes.size());
  count_kind(channel, bytes);
  remember(channel, time_us, bytes);
}

void Model::count_kind(Channel& channel, std::span<const uint8_t> bytes) {
  const auto fingerprint = lcm_schema::fingerprint_of(bytes);
  if (!fingerprint) {
    ++channel.untyped;
    return;
  }
  if (*fingerprint != channel.fingerprint) {
    if (channel.fingerprint != 0) ++channel.type_changes;
    channel.fingerprint = *fingerprint;
    channel.candidates = decoder_->schema().with_fingerprint(*fingerprint);
    channel.tiled =
        channel.type() >= 0 &&
        comes_in_tiles(decoder_->schema().structures()[static_cast<std::size_t>(channel.type())]);
  }
  if (channel.candidates.empty()) {
    ++channel.unknown;
  } else if (decoder_->check(channel.type(), bytes) != lcm_schema::DecodeStatus::ok) {
    ++channel.damaged;
  }
}

void Model::remember(Channel& channel, int64_t time_us, std::span<const uint8_t> bytes) {
  channel.last.time_us = time_us;
  channel.last.bytes.assign(bytes.begin(), bytes.end());
  if (keep_ == Keep::newest) return;
  const std::size_t limit = channel.tiled ? kTiledHistoryBytes : kHistoryBytes;
  if (bytes.size() > limit / 2) return;
  const int64_t since_us =
      channel.history.empty() ? kHistoryStepUs : time_us - channel.history.back().time_us;
  if (!channel.tiled && since_us >= 0 && since_us < kHistoryStepUs) return;
  Sample sample;
  if (channel.history.size() >= kHistoryCount || channel.history_bytes + bytes.size() > limit) {
    do {
      sample = std::move(channel.history.front());
      channel.history_bytes -= sample.bytes.size();
      channel.history.pop_front();
    } while (channel.history_bytes + bytes.size() > limit);
  }
  sample.time_us = time_us;
  sample.bytes.assign(bytes.begin(), bytes.end());
  channel.history_bytes += bytes.size();
  channel.history.push_back(std::move(sample));
}

Loss Model::loss(const Sender& sender, const Sender::Use& use) const {
  const int64_t nameless = sender.sequence.lost() + sender.incomplete_unknown;
  if (sender.uses.size() == 1) return {use.incomplete + nameless, false};
  // Shares of the cumulated counts, so that all shares together are exactly the loss.
  int64_t before = 0;
  int64_t all = 0;
  for (const Sender::Use& other : sender.uses) {
    if (&other < &use) before += other.count;
    all += other.count;
  }
  if (all == 0 || nameless == 0) return {use.incomplete, false};
  const auto share = [&](int64_t count) {
    return static_cast<int64_t>(static_cast<double>(nameless) * static_cast<double>(count) /
                                static_cast<double>(all));
  };
  return {use.incomplete + share(before + use.count) - share(before), true};
}

Loss Model::loss(int channel) const {
  Loss sum;
  for (const Sender& sender : senders_) {
    for (const Sender::Use& use : sender.uses) {
      if (use.channel != channel) continue;
      const Loss part = loss(sender, use);
      sum.count += part.count;
      sum.estimated = sum.estimated || (part.estimated && part.count > use.incomplete);
    }
  }
  return sum;
}

int64_t Model::lost() const {
  int64_t sum = 0;
  for (const Sender& sender : senders_) sum += sender.lost();
  return sum;
}

void Model::choose_next_type(int channel) { ++channels_[static_cast<std::size_t>(channel)].choice; }

void Model::clear() {
  channels_.clear();
  channel_of_name_.clear();
  for (Sender& sender : senders_) {
    sender.uses.clear();
    sender.sequence.forget_losses();
    sender.messages = sender.bytes = sender.incomplete = sender.incomplete_unknown = 0;
  }
  messages_ = foreign_ = ignored_ = 0;
}

bool Model::decode_last(int channel, lcm_schema::Tree& tree) const {
  const Channel& self = channels_[static_cast<std::size_t>(channel)];
  return self.type() >= 0 &&
         decoder_->decode(self.type(), self.last.bytes, tree) == lcm_schema::DecodeStatus::ok;
}

}  // namespace marco::spy
