#include "lcm_tools/spy/receiver.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <cstring>
#include <vector>

#include "lcm_tools/process/wall_clock.hpp"

namespace marco::spy {
namespace {

constexpr std::size_t kBatch = 256;
constexpr std::size_t kDatagramBytes = 65536;
constexpr int kDefaultBufferBytes = 16 << 20;

// Arrays that recvmmsg fills again and again.
class Batch {
 public:
  Batch() : bytes_(kBatch * kDatagramBytes), control_(kBatch) {
    for (std::size_t i = 0; i < kBatch; ++i) {
      parts_[i] = {bytes_.data() + i * kDatagramBytes, kDatagramBytes};
      msghdr& header = headers_[i].msg_hdr;
      header = {};
      header.msg_iov = &parts_[i];
      header.msg_iovlen = 1;
      header.msg_name = &senders_[i];
      header.msg_control = control_[i].bytes;
    }
  }

  int receive(int socket) {
    for (mmsghdr& header : headers_) {
      header.msg_hdr.msg_namelen = sizeof(sockaddr_in);
      header.msg_hdr.msg_controllen = sizeof(Control);
    }
    return ::recvmmsg(socket, headers_.data(), kBatch, MSG_WAITFORONE, nullptr);
  }

  Address sender(std::size_t i) const {
    return {ntohl(senders_[i].sin_addr.s_addr), ntohs(senders_[i].sin_port)};
  }
  std::span<const uint8_t> datagram(std::size_t i) const {
    return {bytes_.data() + i * kDatagramBytes, headers_[i].msg_len};
  }
  // When the kernel had it [us].
  int64_t time_us(std::size_t i) {
    for (cmsghdr* part = CMSG_FIRSTHDR(&headers_[i].msg_hdr); part != nullptr;
         part = CMSG_NXTHDR(&headers_[i].msg_hdr, part)) {
      if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMPNS) continue;
      timespec time = {};
      std::memcpy(&time, CMSG_DATA(part), sizeof time);
      return int64_t{time.tv_sec} * 1000000 + time.tv_nsec / 1000;
    }
    return process::wall_clock_us();
  }

 private:
  struct Control {
    alignas(cmsghdr) uint8_t bytes[64];
  };
  std::vector<uint8_t> bytes_;
  std::vector<Control> control_;
  std::array<iovec, kBatch> parts_ = {};
  std::array<sockaddr_in, kBatch> senders_ = {};
  std::array<mmsghdr, kBatch> headers_ = {};
};

}  // namespace

SharedModel::Look::Look(SharedModel& shared) : shared_(shared) {
  shared_.looking.fetch_add(1);
  shared_.mutex.lock();
}

SharedModel::Look::~Look() {
  shared_.mutex.unlock();
  shared_.looking.fetch_sub(1);
  shared_.looking.notify_all();
}

Receiver::Receiver(const diagnosis::UdpUrl& url, SharedModel& shared)
    : socket_(url, url.recv_buf_bytes > 0 ? url.recv_buf_bytes : kDefaultBufferBytes),
      shared_(shared) {
  // Here, not in the thread: who sees the screen is heard.
  std::string error;
  joined_ = socket_.join(error);
  thread_ = std::thread([this] { run(); });
}

Receiver::~Receiver() {
  stop_ = true;
  thread_.join();
}

void Receiver::run() {
  using Clock = std::chrono::steady_clock;
  const timeval patience = {0, 100000};
  ::setsockopt(socket_.descriptor(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  Batch batch;
  std::string error;
  auto tried = Clock::now();
  while (!stop_) {
    // The route may come later than the spy.
    if (!joined_ && Clock::now() - tried > std::chrono::milliseconds(500)) {
      joined_ = socket_.join(error);
      tried = Clock::now();
    }
    const int count = batch.receive(socket_.descriptor());
    if (count <= 0) continue;
    for (int waiting = shared_.looking; waiting > 0; waiting = shared_.looking)
      shared_.looking.wait(waiting);
    const std::lock_guard lock(shared_.mutex);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      const Address sender = batch.sender(i);
      if (sender.port == shared_.ignored_port) continue;
      shared_.model.add_datagram(batch.time_us(i), sender, batch.datagram(i));
    }
  }
}

}  // namespace marco::spy
