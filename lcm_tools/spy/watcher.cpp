#include "lcm_tools/spy/watcher.hpp"

#include <chrono>

namespace marco::spy {

using std::chrono::milliseconds;

Watcher::Watcher(const diagnosis::UdpUrl& url, SharedModel& shared, const Receiver& receiver)
    : url_(url), shared_(shared), receiver_(receiver) {
  shared_.ignored_port = prober_.port();
  thread_ = std::thread([this] { run(); });
}

Watcher::~Watcher() {
  stop_ = true;
  thread_.join();
}

void Watcher::copy_to(Surroundings& around) const {
  const std::lock_guard lock(mutex_);
  around.publishers = publishers_;
  around.listeners = listeners_;
  around.findings = findings_;
}

void Watcher::look(Depth depth) {
  const std::lock_guard one_at_a_time(looking_);
  std::vector<Address> senders;
  int64_t heard = 0;
  {
    const SharedModel::Look look(shared_);
    for (const Sender& sender : shared_.model.senders()) senders.push_back(sender.address);
    heard = shared_.model.messages();
  }
  std::map<Address, Process> publishers = name_publishers(senders);
  std::vector<Listener> listeners = diagnosis::find_listeners(url_.port, receiver_.inode());
  std::vector<Finding> findings;
  if (heard > 0 || depth == Depth::silence_too) {
    diagnosis::NetworkState state = diagnosis::look_at_network(url_, prober_, heard);
    state.listeners = listeners;
    findings = diagnose(state);
  }
  const std::lock_guard lock(mutex_);
  publishers_ = std::move(publishers);
  listeners_ = std::move(listeners);
  findings_ = std::move(findings);
}

// A sender's name stays known when its process is gone; only new ones are looked up.
std::map<Address, Process> Watcher::name_publishers(const std::vector<Address>& senders) const {
  std::map<Address, Process> known;
  {
    const std::lock_guard lock(mutex_);
    known = publishers_;
  }
  std::vector<Address> asked;
  for (const Address& sender : senders) {
    if (!known.contains(sender)) asked.push_back(sender);
  }
  if (!asked.empty()) known.merge(diagnosis::find_publishers(asked));
  return known;
}

std::size_t Watcher::sender_count() const {
  const SharedModel::Look look(shared_);
  return shared_.model.senders().size();
}

void Watcher::run() {
  const auto start = std::chrono::steady_clock::now();
  while (!stop_) {
    const std::size_t senders = sender_count();
    // A publisher needs a moment before silence means anything.
    const bool silent = std::chrono::steady_clock::now() - start > milliseconds(1500);
    look(silent ? Depth::silence_too : Depth::sockets);
    for (int waited_ms = 0; waited_ms < 1000 && !stop_ && sender_count() == senders;
         waited_ms += 20) {
      std::this_thread::sleep_for(milliseconds(20));
    }
  }
}

}  // namespace marco::spy
