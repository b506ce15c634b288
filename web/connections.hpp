#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <utility>

namespace marco::web {

/// The connections that are no WebSockets, and which of them is closed where one more has no room:
/// of the address that has most of them, the one that has waited longest for a request; where none
/// waits, the one whose answer takes longest. One thread.
class Connections {
 public:
  static constexpr std::size_t kMost = 256;

  struct Open {
    std::string address;
    std::function<void()> close;
    bool is_waiting = true;  ///< for a request, or to be refused
  };
  using Place = std::list<Open>::iterator;

  /// Closes another where there is no room. @returns whether it did
  bool add(const std::string& address, std::function<void()> close, Place& place) {
    const bool is_full = open_.size() >= kMost;
    if (is_full) to_close()->close();
    place = open_.insert(open_.end(), {address, std::move(close)});
    return is_full;
  }
  void remove(Place place) { open_.erase(place); }
  /// It waits, or is being answered, from now on.
  void set_waiting(Place place, bool is_waiting) {
    place->is_waiting = is_waiting;
    open_.splice(open_.end(), open_, place);
  }
  std::size_t size() const { return open_.size(); }

 private:
  Place to_close() {
    std::map<std::string, int> count;
    for (const Open& one : open_) ++count[one.address];
    return std::max_element(open_.begin(), open_.end(), [&](const Open& a, const Open& b) {
      return std::pair(count[a.address], a.is_waiting) < std::pair(count[b.address], b.is_waiting);
    });
  }

  std::list<Open> open_;  // longest in its state first
};

}  // namespace marco::web
