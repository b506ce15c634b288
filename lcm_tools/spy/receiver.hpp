#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include "lcm_tools/diagnosis/listening_socket.hpp"
#include "lcm_tools/spy/model.hpp"

namespace marco::spy {

/// A model used by the receiving and the drawing thread. The receiving thread comes back for the
/// lock thousands of times a second; `Look` makes it stand back, so that on a single core too the
/// drawing thread gets its turn at once.
struct SharedModel {
  explicit SharedModel(const lcm_schema::Decoder& decoder, Keep keep = Keep::history)
      : model(decoder, keep) {}

  /// Held while reading (or changing) the model from outside the hearing thread.
  class Look {
   public:
    explicit Look(SharedModel& shared);
    ~Look();
    Look(const Look&) = delete;
    Look& operator=(const Look&) = delete;

   private:
    SharedModel& shared_;
  };

  std::mutex mutex;
  std::atomic<int> looking = 0;
  std::atomic<uint16_t> ignored_port = 0;  ///< our own probes
  Model model;
};

/// Receives: one thread, recvmmsg in batches, the kernel's arrival times. The queue between network
/// and model is the socket's buffer; what it loses is in the sequence numbers.
class Receiver {
 public:
  /// @throws std::runtime_error as ListeningSocket.
  Receiver(const diagnosis::UdpUrl& url, SharedModel& shared);
  ~Receiver();
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  uint64_t inode() const { return socket_.inode(); }
  int64_t buffer_bytes() const { return socket_.buffer_bytes(); }

 private:
  void run();

  diagnosis::ListeningSocket socket_;
  SharedModel& shared_;
  bool joined_ = false;  // after the constructor the thread's alone
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace marco::spy
