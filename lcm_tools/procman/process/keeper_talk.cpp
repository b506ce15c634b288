// What the keeper writes and to whom it talks: the command's output file, and deputies.
#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "lcm_tools/procman/process/keeper.hpp"
#include "lcm_tools/procman/process/process_tree.hpp"

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

void Keeper::open_output() {
  output_.reset(open(state_.output_file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  struct stat status = {};
  if (!output_.is_open() || fstat(output_.get(), &status) != 0) {
    throw_errno("cannot write " + state_.output_file);
  }
  state_.output_inode = static_cast<int64_t>(status.st_ino);
  state_.output_end = status.st_size;
}

// A command that writes without end must not fill the disk: there are two files of it at most.
void Keeper::begin_new_file() {
  try {
    const std::string old = state_.output_file + ".1";
    if (rename(state_.output_file.c_str(), old.c_str()) != 0) throw_errno(old);
    open_output();
    state_.output_begin = state_.output_shown = 0;
  } catch (const std::runtime_error&) {
    // Somebody has taken the folder away: what is open is emptied instead.
    if (output_.is_open() && ftruncate(output_.get(), 0) == 0) state_.output_end = 0;
  }
}

void Keeper::write_output(const char* bytes, std::size_t size) {
  if (state_.output_end > 0 &&
      state_.output_end + static_cast<int64_t>(size) > state_.output_limit) {
    begin_new_file();
  }
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
  if (!caller.is_open() || peer_of(caller) != getuid()) return;
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
  if (message.kind == "shown" && message.output_inode == state_.output_inode) {
    state_.output_shown = message.output_shown;
  }
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
