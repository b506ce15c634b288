#include "web/outbox.hpp"

namespace marco::web {

bool Outbox::push_control(Outgoing message) {
  control_bytes_ += message.bytes();
  control_.push_back(std::move(message));
  return control_bytes_ <= kMostControlBytes;
}

void Outbox::push_data(uint32_t channel, uint64_t slot, Outgoing message) {
  const Key key{channel, slot};
  data_bytes_ += message.bytes();
  if (const auto place = places_.find(key); place != places_.end()) {
    data_bytes_ -= place->second->message.bytes();
    place->second->message = std::move(message);
  } else {
    places_[key] = data_.insert(data_.end(), {key, std::move(message)});
  }
  while (data_bytes_ > kMostBytes && data_.size() > 1) {
    erase(data_.begin());
    ++dropped_;
  }
}

void Outbox::drop(uint32_t channel) {
  for (auto place = places_.lower_bound({channel, 0});
       place != places_.end() && place->first.first == channel;) {
    const auto at = place->second;
    ++place;
    erase(at);
  }
}

void Outbox::erase(std::list<Waiting>::iterator at) {
  data_bytes_ -= at->message.bytes();
  places_.erase(at->key);
  data_.erase(at);
}

void Outbox::clear() {
  dropped_ += static_cast<int64_t>(control_.size() + data_.size());
  control_.clear();
  data_.clear();
  places_.clear();
  control_bytes_ = data_bytes_ = 0;
}

std::optional<Outgoing> Outbox::take() {
  std::optional<Outgoing> first;
  if (!control_.empty()) {
    first = std::move(control_.front());
    control_bytes_ -= first->bytes();
    control_.pop_front();
  } else if (!data_.empty()) {
    first = data_.front().message;
    erase(data_.begin());
  }
  sent_bytes_ = first ? first->bytes() : 0;
  return first;
}

}  // namespace marco::web
