// What the keeper writes and to whom it talks: the command's output file, and deputies.
#include <fcntl.h>
#include <sys/socket.h>

#include <cerrno>
#include <utility>

#include "procman/process/keeper.hpp"
#include "procman/process/process_tree.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kGrowthPeriodUs = 5'000;

}  // namespace

bool Keeper::read_output() {
  char bytes[65536];
  const ssize_t size = read(master_.get(), bytes, sizeof bytes);
  if (size <= 0) return false;
  write_output(bytes, static_cast<std::size_t>(size));
  if (!tell_growth_us_) tell_growth_us_ = monotonic_us() + kGrowthPeriodUs;
  return true;
}

void Keeper::write_output(const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t written = write(output_.get(), bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      state_.output_lost += static_cast<int64_t>(size);
      return;
    }
    bytes += written;
    size -= static_cast<std::size_t>(written);
    state_.output_end += written;
  }
}

void Keeper::accept_deputy() {
  Descriptor caller(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
  ucred who = {};
  socklen_t size = sizeof who;
  if (!caller.is_open() || getsockopt(caller.get(), SOL_SOCKET, SO_PEERCRED, &who, &size) != 0 ||
      who.uid != getuid()) {
    return;
  }
  deputy_ = std::move(caller);
  owes_state_ = !send("state");
  owes_ended_ = finished_;
}

void Keeper::read_deputy() {
  std::string bytes(kMaxKeeperMessage, '\0');
  const ssize_t size = recv(deputy_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size <= 0) {
    deputy_.reset();
    return;
  }
  bytes.resize(static_cast<std::size_t>(size));
  if (const auto message = decode_keeper_message(bytes)) on_message(*message);
}

void Keeper::on_message(const KeeperMessage& message) {
  if (message.kind == "stop") begin_stop(message.signal, message.allowed_s);
  if (message.kind == "shown") state_.output_shown = message.output_shown;
  if (message.kind == "release" && finished_) released_ = true;
}

// A deputy too busy to read must not hold up the command: the caller tries again.
bool Keeper::send(const char* kind) {
  if (!deputy_.is_open()) return false;
  state_.kind = kind;
  const std::string bytes = encode(state_);
  return ::send(deputy_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) ==
         static_cast<ssize_t>(bytes.size());
}

}  // namespace marco::procman
