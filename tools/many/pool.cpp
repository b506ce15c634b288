#include "tools/many/pool.hpp"

#include <cstdio>
#include <deque>
#include <map>

#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "tools/many/child.hpp"

namespace marco::many {
namespace {

constexpr int kMostTries = 5;

class Pool {
 public:
  Pool(const Store& store,
       const std::vector<Entry>& entries,
       const std::vector<std::string>& command)
      : store_(store), entries_(entries), command_(command) {
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (!is_done(store_, entries_[i])) waiting_.push_back(i);
    }
    begun_with_ = waiting_.size();
  }

  void run(std::size_t jobs) {
    while (!running_.empty() || (!waiting_.empty() && process::interrupted_by() == 0)) {
      while (running_.size() < jobs && !waiting_.empty() && process::interrupted_by() == 0) start();
      take(wait_for_child(-1));
    }
  }

 private:
  void start() {
    const std::size_t i = waiting_.front();
    waiting_.pop_front();
    ++tries_[i];
    std::vector<std::string> words = command_;
    words.insert(words.begin(), {"--task", std::to_string(i + 1)});
    running_[start_child(sibling_path("marco-map-many"), std::move(words),
                         store_.printed(entries_[i]))] = i;
  }

  void take(const ChildEnd& end) {
    const auto found = running_.find(end.pid);
    if (found == running_.end()) return;
    const std::size_t i = found->second;
    running_.erase(found);
    const Entry& entry = entries_[i];
    if (is_done(store_, entry)) {
      ++done_;
      print(stderr, "[%zu/%zu] %s\n", done_, begun_with_, entry.name.c_str());
    } else if (tries_[i] < kMostTries) {
      waiting_.push_back(i);
    } else if (process::interrupted_by() == 0) {
      record_failure(store_, entry, "was killed five times", end.cpu_s);
    }
  }

  const Store& store_;
  const std::vector<Entry>& entries_;
  const std::vector<std::string>& command_;
  std::deque<std::size_t> waiting_;       // of entries_
  std::map<pid_t, std::size_t> running_;  // entries by process
  std::map<std::size_t, int> tries_;
  std::size_t begun_with_ = 0, done_ = 0;
};

}  // namespace

void run_jobs(const Store& store,
              const std::vector<Entry>& entries,
              int jobs,
              const std::vector<std::string>& command) {
  Pool(store, entries, command).run(static_cast<std::size_t>(jobs));
}

}  // namespace marco::many
