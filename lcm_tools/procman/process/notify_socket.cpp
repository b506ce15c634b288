#include "lcm_tools/procman/process/notify_socket.hpp"

#include <sys/socket.h>
#include <sys/syscall.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include "lcm_tools/procman/process/process_tree.hpp"

namespace marco::procman {
namespace {

constexpr int kMostAtOnce = 100;  // a flood does not keep the keeper from its timers
constexpr std::size_t kMostProcesses = 100;

bool has_ended(const Descriptor& process) {
  pollfd end = {process.get(), POLLIN, 0};
  return poll(&end, 1, 0) > 0;
}

/// Remembers a descendant of this process. @returns whether it is known now.
bool add(std::map<pid_t, Descriptor>& processes, pid_t pid) {
  const auto known = processes.find(pid);
  if (known != processes.end() && !has_ended(known->second)) return true;
  Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
  // The id is looked up after it is held.
  const std::vector<pid_t> tree = descendants_of(getpid());
  if (!process.is_open() || processes.size() >= kMostProcesses ||
      std::find(tree.begin(), tree.end(), pid) == tree.end()) {
    return false;
  }
  processes.insert_or_assign(pid, std::move(process));
  return true;
}

HeartbeatWatch::Usage usage_of(pid_t pid) {
  const ProcessStat stat = read_process(pid).value_or(ProcessStat{});
  return {stat.is_runnable, stat.cpu_ticks};
}

}  // namespace

NotifySocket::~NotifySocket() {
  if (socket_.is_open()) unlink(path_.c_str());
}

void NotifySocket::open(const std::string& path) {
  const auto address = socket_address(path);
  if (!address) throw std::runtime_error("too long for a socket: " + path);
  path_ = path;
  socket_.reset(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int on = 1;
  if (!socket_.is_open() ||
      setsockopt(socket_.get(), SOL_SOCKET, SO_PASSCRED, &on, sizeof on) != 0 ||
      bind(socket_.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0) {
    throw_errno("cannot listen at " + path);
  }
  setenv("NOTIFY_SOCKET", path.c_str(), 1);
  setenv("WATCHDOG_USEC", std::to_string(HeartbeatWatch::kSilentUs).c_str(), 1);
}

void NotifySocket::receive(pid_t main) {
  for (int n = 0; n < kMostAtOnce; ++n) {
    char bytes[4096];
    // Room for the sender alone: descriptors that come along are closed by the kernel.
    alignas(cmsghdr) char about[CMSG_SPACE(sizeof(ucred))];
    iovec text = {bytes, sizeof bytes};
    msghdr message = {};
    message.msg_iov = &text;
    message.msg_iovlen = 1;
    message.msg_control = about;
    message.msg_controllen = sizeof about;
    const ssize_t size = recvmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (size < 0) return;
    const cmsghdr* header = CMSG_FIRSTHDR(&message);
    if (header == nullptr || header->cmsg_type != SCM_CREDENTIALS) continue;
    ucred sender = {};
    std::memcpy(&sender, CMSG_DATA(header), sizeof sender);
    std::string_view lines(bytes, static_cast<std::size_t>(size));
    while (!lines.empty()) {
      const std::size_t end = std::min(lines.find('\n'), lines.size());
      on_line(lines.substr(0, end), sender.pid, main);
      lines.remove_prefix(std::min(end + 1, lines.size()));
    }
  }
}

void NotifySocket::on_line(std::string_view line, pid_t sender, pid_t main) {
  if (line == "WATCHDOG=1" && add(beating_, sender)) watch_.on_beat(sender);
  if (line == "STOPPING=1") {
    watch_.forget(sender);
    beating_.erase(sender);
  }
  if (line == "OUTLIVES=1" && sender != main) add(survivors_, sender);
}

bool NotifySocket::is_silent(int64_t now_us) {
  std::erase_if(beating_, [this](const auto& process) {
    if (!has_ended(process.second)) return false;
    watch_.forget(process.first);
    return true;
  });
  return watch_.step(now_us, usage_of);
}

std::set<pid_t> NotifySocket::survivors() {
  std::erase_if(survivors_, [](const auto& process) { return has_ended(process.second); });
  std::set<pid_t> alive;
  for (const auto& [pid, process] : survivors_) alive.insert(pid);
  return alive;
}

}  // namespace marco::procman
