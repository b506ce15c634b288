#pragma once

#include <deque>
#include <functional>
#include <utility>

namespace marco::web {

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
