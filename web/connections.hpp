#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <utility>

namespace marco::web {

/// The connections that are not WebSockets, and which of them is closed where one more has no room:
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
    if (is_full) {
      const auto close_other = to_close()->close;
      close_other();
    }
    ++count_[address];
    place = open_.insert(open_.end(), {address, std::move(close)});
    return is_full;
  }
  void remove(Place place) {
    const auto count = count_.find(place->address);
    if (--count->second == 0) count_.erase(count);
    open_.erase(place);
  }
  /// It waits, or is being answered, from now on.
  void set_waiting(Place place, bool is_waiting) {
    place->is_waiting = is_waiting;
    open_.splice(open_.end(), open_, place);
  }
  std::size_t size() const { return open_.size(); }

 private:
  Place to_close() {
    const auto busiest = std::max_element(count_.begin(), count_.end(),
                                          [](auto& a, auto& b) { return a.second < b.second; });
    const auto is_its = [&](const Open& one) { return one.address == busiest->first; };
    const auto waits = std::find_if(open_.begin(), open_.end(),
                                    [&](const Open& one) { return is_its(one) && one.is_waiting; });
    return waits != open_.end() ? waits : std::find_if(open_.begin(), open_.end(), is_its);
  }

  std::map<std::string, int> count_;  // by address
  std::list<Open> open_;              // longest in its state first
};

}  // namespace marco::web
