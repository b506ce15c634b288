#include "drivers/process/guardian_link.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <new>

namespace marco::drivers {
namespace {

constexpr int kStartMs = 5000, kAnswerMs = 1000;
constexpr int64_t kHangsNs = 2'000'000'000;
constexpr int64_t kLongestStepNs = 50'000'000;  // what counts of a step: this process may have hung

/// Above the descriptors that the guardian begins with.
FileHandle moved_up(int fd) {
  const FileHandle low(fd);
  return FileHandle(fcntl(fd, F_DUPFD_CLOEXEC, 10));
}

}  // namespace

GuardianLink::GuardianLink(std::vector<std::string> arguments)
    : arguments_(std::move(arguments)),
      memory_(moved_up(memfd_create("marco-guardian", MFD_CLOEXEC))) {
  void* page = MAP_FAILED;
  if (ftruncate(memory_.get(), sizeof(GuardianBeat)) == 0) {
    page =
        mmap(nullptr, sizeof(GuardianBeat), PROT_READ | PROT_WRITE, MAP_SHARED, memory_.get(), 0);
  }
  if (page == MAP_FAILED) throw std::runtime_error("no memory to share with a guardian");
  shared_ = new (page) GuardianBeat;
}

GuardianLink::~GuardianLink() { munmap(shared_, sizeof(GuardianBeat)); }

void GuardianLink::spawn() {
  int ends[2] = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) {
    throw StreamLost("no socket to a guardian");
  }
  FileHandle ours = moved_up(ends[0]);
  const FileHandle theirs = moved_up(ends[1]);
  std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  program += "/marco-guardian";
  std::vector<char*> argv{program.data()};
  for (std::string& argument : arguments_) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, theirs.get(), kGuardianSocket);
  posix_spawn_file_actions_adddup2(&files, memory_.get(), kGuardianMemory);
  pid_t starter = 0;
  const int failure = posix_spawn(&starter, argv[0], &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (failure != 0) throw StreamLost(program + ": " + std::strerror(failure));
  waitpid(starter, nullptr, 0);  // the guardian itself is nobody's child
  socket_ = std::move(ours);
}

void GuardianLink::start() {
  if (socket_.valid()) return;
  spawn();
  if (await(GuardianWord::ready, kStartMs)) return;
  end_it();
  throw StreamLost("the guardian that stops the device in an emergency does not start");
}

bool GuardianLink::send(GuardianWord word,
                        const std::vector<uint8_t>& bytes,
                        int descriptor) const {
  iovec parts[] = {{&word, sizeof word}, {const_cast<uint8_t*>(bytes.data()), bytes.size()}};
  alignas(cmsghdr) char about[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = parts;
  message.msg_iovlen = 2;
  if (descriptor >= 0) {
    message.msg_control = about;
    message.msg_controllen = sizeof about;
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(header), &descriptor, sizeof descriptor);
  }
  return sendmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0;
}

/// @returns whether the word came. Without a timeout it only reads what is there.
bool GuardianLink::await(GuardianWord word, int timeout_ms) {
  const int64_t until = monotonic_ns() + int64_t{timeout_ms} * 1'000'000;
  while (socket_.valid()) {
    char bytes[kMostGuardianBytes];
    const ssize_t size = recv(socket_.get(), bytes, sizeof bytes, MSG_DONTWAIT);
    if (size == 0 || (size < 0 && errno != EAGAIN && errno != EINTR)) {
      socket_.reset();
    } else if (size > 0) {
      const std::string text(bytes + 1, static_cast<std::size_t>(size) - 1);
      const auto said = static_cast<GuardianWord>(bytes[0]);
      if (said == GuardianWord::warning) spdlog::warn("{}", text);
      if (said == GuardianWord::ready) pid_ = static_cast<pid_t>(std::stol(text));
      if (said == word) return true;
    } else {
      const int64_t left_ms = (until - monotonic_ns()) / 1'000'000;
      if (left_ms <= 0) return false;
      pollfd source{socket_.get(), POLLIN, 0};
      poll(&source, 1, static_cast<int>(left_ms));
    }
  }
  return false;
}

/// Also one that hangs. The id is its own as long as its end of the socket is open.
void GuardianLink::end_it() {
  if (socket_.valid() && pid_ > 0) kill(pid_, SIGKILL);
  socket_.reset();
  pid_ = 0;
}

void GuardianLink::share(int line) {
  stop_bytes_.clear();
  its_silence_ns_ = 0;
  shared_->taken = false;
  shared_->driver_ns = monotonic_ns();
  if (send(GuardianWord::line, {}, line) && await(GuardianWord::done, kAnswerMs)) return;
  end_it();
  throw StreamLost("the guardian does not answer");
}

void GuardianLink::let_go() noexcept {
  if (send(GuardianWord::let_go, {}) && await(GuardianWord::done, kAnswerMs)) return;
  end_it();
}

void GuardianLink::beat(const std::vector<uint8_t>& stop_bytes) {
  if (stop_bytes != stop_bytes_ && send(GuardianWord::stop, stop_bytes)) stop_bytes_ = stop_bytes;
  await(GuardianWord::warning, 0);
  if (!socket_.valid()) throw StreamLost("the guardian has ended");
  const int64_t now = monotonic_ns();
  its_silence_ns_ += std::min(now - shared_->driver_ns, kLongestStepNs);
  if (shared_->guardian_ns != its_beat_ns_) its_silence_ns_ = 0;
  its_beat_ns_ = shared_->guardian_ns;
  if (its_silence_ns_ > kHangsNs) throw StreamLost("the guardian hangs");
  if (!late()) shared_->driver_ns = now;
}

bool GuardianLink::late() const {
  return shared_->taken || monotonic_ns() - shared_->driver_ns > GuardianBeat::kSilentNs;
}

double GuardianLink::take_hang_s() {
  if (!late()) return 0.0;
  const int64_t now = monotonic_ns();
  const int64_t hung_ns = now - shared_->driver_ns.exchange(now);
  shared_->taken = false;
  return 1e-9 * static_cast<double>(std::max<int64_t>(hung_ns, 1));
}

GuardedStream::GuardedStream(ByteStream& stream, GuardianLink& guardian)
    : stream_(stream), guardian_(guardian) {
  guardian_.share(stream.descriptor());
}

std::size_t GuardedStream::read(std::span<uint8_t> into, std::chrono::microseconds timeout) {
  std::size_t count = stream_.read(into, timeout);
  if (!guardian_.late()) return count;
  if (count == 0) count = stream_.read(into, std::chrono::microseconds(0));
  const double hung_s = guardian_.take_hang_s();
  spdlog::warn("this driver hung for {:.1f} s: its device was stopped", hung_s);
  if (on_hang) on_hang(hung_s);
  return count;
}

void GuardedStream::write(std::span<const uint8_t> bytes) {
  if (!guardian_.late()) {
    stream_.write(bytes);
    if (!guardian_.late()) return;
  }
  discard_output(stream_.descriptor());
  stream_.write(guardian_.stop_bytes());
}

}  // namespace marco::drivers
