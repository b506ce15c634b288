#include "lcm_tools/procman/process/keeper_link.hpp"

#include <spawn.h>
#include <sys/socket.h>

#include <cerrno>
#include <csignal>
#include <stdexcept>

namespace marco::procman {

KeeperLink KeeperLink::spawn(const std::string& program,
                             const std::string& socket_path,
                             const KeeperMessage& run) {
  if (encode(run).size() > kMaxKeeperMessage)
    throw std::runtime_error("the exec string is too long");
  int ends[2] = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) throw_errno("socketpair");
  KeeperLink link{Descriptor(ends[0])};
  const Descriptor theirs(ends[1]);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, theirs.get(), 3);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t signals;
  sigemptyset(&signals);
  posix_spawnattr_setsigmask(&attributes, &signals);
  sigfillset(&signals);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  std::string name = program;
  std::string id = run.spec.id;
  std::string path = socket_path;
  char* arguments[] = {name.data(), id.data(), path.data(), nullptr};
  pid_t pid = 0;
  const int failure = posix_spawn(&pid, program.c_str(), &actions, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  errno = failure;
  if (failure != 0) throw_errno("cannot run " + program);
  link.send(run);
  return link;
}

std::optional<KeeperLink> KeeperLink::connect(const std::string& socket_path) {
  const auto address = socket_address(socket_path);
  if (!address) return std::nullopt;
  Descriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  if (!socket.is_open() ||
      ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0) {
    return std::nullopt;
  }
  if (peer_of(socket) != getuid()) return std::nullopt;
  return KeeperLink(std::move(socket));
}

void KeeperLink::send(const KeeperMessage& message) const {
  const std::string bytes = encode(message);
  ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

std::vector<KeeperMessage> KeeperLink::receive(bool& closed) {
  std::vector<KeeperMessage> messages;
  std::string bytes(kMaxKeeperMessage, '\0');
  while (true) {
    const ssize_t size = recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (size < 0 && errno == EINTR) continue;
    closed = size == 0 || (size < 0 && errno != EAGAIN);
    if (size <= 0) return messages;
    auto message =
        decode_keeper_message(std::string_view(bytes).substr(0, static_cast<std::size_t>(size)));
    if (message) messages.push_back(std::move(*message));
  }
}

}  // namespace marco::procman
