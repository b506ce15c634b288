#pragma once

#include <cstdint>
#include <deque>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace marco::web {

/// A WebSocket message on its way out. Clients share its body.
struct Outgoing {
  bool is_text = false;
  std::string head;                         ///< before the body; "" of texts
  std::shared_ptr<const std::string> body;  ///< never null
  std::size_t bytes() const { return head.size() + body->size(); }
};

/// What waits to be sent to one client, bounded whatever the client does. Control messages go first
/// and in order. Of data, a newer message takes the place of a waiting one of the same channel and
/// slot. What is small, as states are, goes before what is large, as parts of maps are; where the
/// small ones never end, half of the bytes are for the large. Above kMostBytes the oldest goes,
/// first of the large.
class Outbox {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{24} << 20;
  static constexpr std::size_t kLargeBytes = std::size_t{32} << 10;
  static constexpr std::size_t kMostControlBytes = std::size_t{8} << 20;

  /// @returns false when the queue is so long that the client must be disconnected.
  bool push_control(Outgoing message);
  /// @param slot  part of the channel that the message is about, e.g. a tile: others stay
  void push_data(uint32_t channel, uint64_t slot, Outgoing message);
  /// Forgets what waits of a channel.
  void drop(uint32_t channel);

  /// The next one. The one before has been sent.
  std::optional<Outgoing> take();
  /// Forgets all that waits, and counts it as dropped.
  void clear();
  bool empty() const { return control_.empty() && places_.empty(); }
  /// With the message that is being sent.
  std::size_t bytes() const { return control_bytes_ + data_bytes_ + sent_bytes_; }
  /// Messages for which there was no room. Those that a newer one overtook are not among them.
  int64_t dropped() const { return dropped_; }

 private:
  using Key = std::pair<uint32_t, uint64_t>;  // channel, slot
  struct Waiting {
    Key key;
    Outgoing message;
  };
  using List = std::list<Waiting>;
  List& list_of(const Outgoing& message) { return message.bytes() < kLargeBytes ? small_ : large_; }
  void erase(List::iterator at);
  Outgoing take_data();

  std::deque<Outgoing> control_;
  List small_, large_;
  std::map<Key, List::iterator> places_;
  std::size_t small_sent_bytes_ = 0;  // since the last large one
  std::size_t control_bytes_ = 0, data_bytes_ = 0, sent_bytes_ = 0;
  int64_t dropped_ = 0;
};

}  // namespace marco::web
