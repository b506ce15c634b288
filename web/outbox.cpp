#include "web/outbox.hpp"

namespace marco::web {

bool Outbox::push_control(Outgoing message) {
  control_bytes_ += message.bytes();
  control_.push_back(std::move(message));
  return control_bytes_ <= kMostControlBytes;
}

void Outbox::push_data(uint32_t channel, uint64_t slot, Outgoing message) {
  const Key key{channel, slot};
  List& list = list_of(message);
  auto place = places_.find(key);
  if (place != places_.end() && &list_of(place->second->message) != &list) {
    erase(place->second);
    place = places_.end();
  }
  data_bytes_ += message.bytes();
  if (place != places_.end()) {
    data_bytes_ -= place->second->message.bytes();
    place->second->message = std::move(message);
  } else {
    places_[key] = list.insert(list.end(), {key, std::move(message)});
  }
  while (data_bytes_ > kMostBytes && places_.size() > 1) {
    erase(large_.size() > 1 ? large_.begin() : small_.begin());
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

void Outbox::erase(List::iterator at) {
  data_bytes_ -= at->message.bytes();
  places_.erase(at->key);
  list_of(at->message).erase(at);
}

void Outbox::clear() {
  dropped_ += static_cast<int64_t>(control_.size() + places_.size());
  control_.clear();
  small_.clear();
  large_.clear();
  places_.clear();
  control_bytes_ = data_bytes_ = 0;
}

Outgoing Outbox::take_data() {
  const bool is_large =
      small_.empty() || (!large_.empty() && small_sent_bytes_ >= large_.front().message.bytes());
  const auto at = is_large ? large_.begin() : small_.begin();
  Outgoing first = at->message;
  small_sent_bytes_ = is_large ? 0 : small_sent_bytes_ + first.bytes();
  erase(at);
  return first;
}

std::optional<Outgoing> Outbox::take() {
  std::optional<Outgoing> first;
  if (!control_.empty()) {
    first = std::move(control_.front());
    control_bytes_ -= first->bytes();
    control_.pop_front();
  } else if (!places_.empty()) {
    first = take_data();
  }
  sent_bytes_ = first ? first->bytes() : 0;
  return first;
}

}  // namespace marco::web
