#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <utility>

/// What keeps the page usable when many clients come at once.
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

/// When wrong tokens are answered: one a second of an address, four a second of all. Right ones
/// need no permission. Pure.
class GuessPace {
 public:
  /// @param now_s  any clock that never steps back. @returns how long to wait with the answer
  double wait_s(const std::string& address, double now_s) {
    constexpr double kOfAddressS = 1.0, kOfAllS = 0.25, kLongestS = 30.0;
    std::erase_if(next_s_, [&](const auto& one) { return one.second <= now_s; });
    const auto of_address = next_s_.find(address);
    const double at_s = std::max({now_s + kOfAllS, next_of_all_s_,
                                  of_address == next_s_.end() ? now_s : of_address->second});
    if (at_s > now_s + kLongestS) return kLongestS;
    next_of_all_s_ = at_s + kOfAllS;
    next_s_[address] = at_s + kOfAddressS;
    return at_s - now_s;
  }

 private:
  double next_of_all_s_ = 0.0;
  std::map<std::string, double> next_s_;  // by address
};

/// What clients ask for, one piece at a time and in turn: what one of them costs delays the others,
/// and a stop, which waits for no turn, by one piece at most. One thread.
class Turns {
 public:
  /// Who may steer comes first; then files and those who come, which cost little; then watchers.
  enum class Rank { steers, requests, watches };

  void add(Rank rank, std::function<void()> piece) { queue_of(rank).push_back(std::move(piece)); }
  bool empty() const { return steers_.empty() && requests_.empty() && watches_.empty(); }
  void clear() {
    for (const Rank rank : {Rank::steers, Rank::requests, Rank::watches}) queue_of(rank).clear();
  }
  /// Does the next piece, if there is one.
  void take_one() {
    constexpr int kRequestsInTurn = 8;
    const bool is_watchers_turn = requests_.empty() || in_turn_ >= kRequestsInTurn;
    auto& queue = !steers_.empty()                        ? steers_
                  : is_watchers_turn && !watches_.empty() ? watches_
                                                          : requests_;
    if (queue.empty()) return;
    if (&queue != &steers_) in_turn_ = &queue == &watches_ ? 0 : in_turn_ + 1;
    const auto piece = std::move(queue.front());
    queue.pop_front();
    piece();
  }

 private:
  std::deque<std::function<void()>>& queue_of(Rank rank) {
    return rank == Rank::steers ? steers_ : rank == Rank::requests ? requests_ : watches_;
  }

  std::deque<std::function<void()>> steers_, requests_, watches_;
  int in_turn_ = 0;  // requests since a watcher's piece
};

}  // namespace marco::web
