#include "lcm_tools/procman/process/deputy_line.hpp"

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <utility>

namespace marco::procman {

DeputyLine::DeputyLine(Descriptor deputy, std::string socket_path)
    : deputy_(std::move(deputy)), socket_path_(std::move(socket_path)) {
  fcntl(deputy_.get(), F_SETFD, FD_CLOEXEC);
}

DeputyLine::~DeputyLine() {
  if (listener_.is_open()) unlink(socket_path_.c_str());
}

KeeperMessage DeputyLine::await_run() const {
  std::string bytes(kMaxKeeperMessage, '\0');
  const ssize_t size = recv(deputy_.get(), bytes.data(), bytes.size(), 0);
  bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  const auto message = decode_keeper_message(bytes);
  if (!message || message->kind != "run") throw std::runtime_error("expected a command line");
  return *message;
}

void DeputyLine::listen() {
  const auto address = socket_address(socket_path_);
  if (!address) throw std::runtime_error("too long for a socket: " + socket_path_);
  listener_.reset(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!listener_.is_open() ||
      bind(listener_.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0 ||
      ::listen(listener_.get(), 4) != 0) {
    throw_errno("cannot listen at " + socket_path_);
  }
}

bool DeputyLine::accept() {
  Descriptor caller(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
  if (!caller.is_open() || peer_of(caller) != getuid()) return false;
  deputy_ = std::move(caller);
  owes_state_ = owes_ended_ = false;
  return true;
}

std::optional<KeeperMessage> DeputyLine::receive() {
  std::string bytes(kMaxKeeperMessage, '\0');
  const ssize_t size = recv(deputy_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  if (size <= 0) {
    deputy_.reset();
    return std::nullopt;
  }
  bytes.resize(static_cast<std::size_t>(size));
  return decode_keeper_message(bytes);
}

void DeputyLine::send_owed(KeeperMessage& state) {
  if (owes_state_) owes_state_ = !send("state", state);
  if (owes_ended_ && !owes_state_) owes_ended_ = !send("ended", state);
}

bool DeputyLine::send(const char* kind, KeeperMessage& state) {
  if (!is_open()) return false;
  state.kind = kind;
  const std::string bytes = encode(state);
  return ::send(deputy_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) ==
         static_cast<ssize_t>(bytes.size());
}

}  // namespace marco::procman
