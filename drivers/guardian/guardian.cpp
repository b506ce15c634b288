#include "drivers/guardian/guardian.hpp"

#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

#include "drivers/transport/wall_clock.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert_robot.hpp"

namespace marco::drivers {

EmergencyListener::EmergencyListener(const std::string& base, const std::string& lcm_url)
    : bus_(lcm_url), base_(base), latch_(base, lcm_url) {
  bus_.subscribe<emergency_stop_t>(
      channels::kEmergencyStop, drops_, [this](const emergency_stop_t& message, const auto&) {
        heard_stop_ = heard_stop_ || message.engaged != 0;
        must_save_ = gate_.on_emergency_stop(from_message(message), wall_now()) || must_save_;
      });
  if (const auto kept = latch_.load()) gate_.on_emergency_stop(*kept, wall_now());
}

EmergencyListener::~EmergencyListener() {
  while (must_save_ || saving_.valid()) {
    if (saving_.valid()) saving_.wait();
    keep();
  }
}

int EmergencyListener::descriptor() { return is_open_ ? bus_.lcm().getFileno() : -1; }

bool EmergencyListener::receive() {
  constexpr int kAtMost = 50;
  heard_stop_ = false;
  try {
    for (int i = 0; is_open_ && i < kAtMost && bus_.handle_once(0); ++i) {
    }
  } catch (const std::runtime_error&) {
    is_open_ = false;  // the driver ends by the same, and the guardian stops what it drove
  }
  return heard_stop_;
}

std::string EmergencyListener::keep() {
  std::string fault;
  if (saving_.valid()) {
    if (saving_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return "";
    fault = saving_.get();
  }
  if (!std::exchange(must_save_, false)) return fault;
  // A disk may take seconds, in which somebody must look after the wheels.
  saving_ = std::async(std::launch::async, [latch = latch_, stop = gate_.latched()] {
    try {
      latch.save(stop);
      return std::string();
    } catch (const std::exception& failure) {
      return std::string("the emergency stop, or its release, could not be saved for a restart: ") +
             failure.what();
    }
  });
  return fault;
}

void EmergencyListener::publish_hung(const std::string& note) {
  const Utime now = wall_now();
  if (!is_open_ || std::abs((now - published_).seconds()) < 0.5) return;
  published_ = now;
  BaseStatus status;
  status.utime = now;
  status.base = base_;
  status.link = BaseStatus::Link::down;
  status.note = gate_.note() + (gate_.stopped() ? "; " : "") + note;
  try {
    bus_.publish(channels::kBaseStatus, to_message(status));
  } catch (const std::runtime_error&) {
    is_open_ = false;
  }
}

using Do = GuardianWatch::Do;

Guardian::Guardian(FileHandle driver,
                   GuardianBeat& beat,
                   std::unique_ptr<EmergencyListener> emergency)
    : driver_(std::move(driver)), beat_(beat), emergency_(std::move(emergency)) {
  say(GuardianWord::ready, std::to_string(getpid()));
}

void Guardian::say(GuardianWord word, const std::string& text) const {
  const std::string message = std::string(1, static_cast<char>(word)) + text;
  send(driver_.get(), message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

GuardianWatch::Driver Guardian::seen() const {
  return {beat_.driver_ns, line_.valid() && !stop_bytes_.empty(), beat_.taken, !driver_.valid()};
}

void Guardian::run() {
  for (Do what = Do::wait; what != Do::leave;) {
    wait();
    receive();
    const int64_t now = monotonic_ns();
    if (emergency_ && emergency_->receive()) watch_.on_emergency_stop(beat_.driver_ns, now);
    beat_.guardian_ns = now;
    what = watch_.step(seen(), now);
    if (what == Do::take) {
      beat_.taken = true;
      discard_output(line_.get());
    }
    if (what == Do::take || what == Do::stop) stop_device(now);
    if (emergency_) look_after_emergency();
  }
}

void Guardian::wait() {
  const bool at_once = emergency_ && emergency_->waits();
  const int64_t wait_ns = at_once ? 0 : watch_.wait_ns(seen(), monotonic_ns());
  pollfd sources[] = {{driver_.get(), POLLIN, 0},
                      {emergency_ ? emergency_->descriptor() : -1, POLLIN, 0}};
  const timespec limit{0, static_cast<long>(wait_ns)};
  ppoll(sources, 2, &limit, nullptr);
}

void Guardian::receive() {
  while (driver_.valid()) {
    uint8_t bytes[kMostGuardianBytes];
    alignas(cmsghdr) char about[CMSG_SPACE(sizeof(int))];
    iovec part{bytes, sizeof bytes};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = about;
    message.msg_controllen = sizeof about;
    const ssize_t size = recvmsg(driver_.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (size <= 0) return on_driver_gone();
    FileHandle line;
    if (const cmsghdr* header = CMSG_FIRSTHDR(&message);
        header != nullptr && header->cmsg_type == SCM_RIGHTS) {
      int descriptor = -1;
      std::memcpy(&descriptor, CMSG_DATA(header), sizeof descriptor);
      line.reset(descriptor);
    }
    on_message(static_cast<GuardianWord>(bytes[0]), {bytes + 1, bytes + size}, std::move(line));
  }
}

void Guardian::on_message(GuardianWord word, std::vector<uint8_t> bytes, FileHandle line) {
  stop_bytes_ = std::move(bytes);
  if (word == GuardianWord::stop) return;
  line_ = std::move(line);
  say(GuardianWord::done);
}

// The next driver may open the line as soon as this process closes it (SerialStream).
void Guardian::on_driver_gone() {
  driver_.reset();
  flock(line_.get(), LOCK_SH);
  ioctl(line_.get(), TIOCNXCL);
}

void Guardian::stop_device(int64_t now) {
  const ssize_t sent = write(line_.get(), stop_bytes_.data(), stop_bytes_.size());
  if (sent == static_cast<ssize_t>(stop_bytes_.size())) return watch_.on_stopped(now);
  if (sent < 0 && errno == EAGAIN) discard_output(line_.get());
}

void Guardian::look_after_emergency() {
  if (const std::string fault = emergency_->keep(); !fault.empty()) {
    say(GuardianWord::warning, fault);
  }
  if (!beat_.taken || stop_bytes_.empty()) return;
  emergency_->publish_hung(driver_.valid() ? "its driver hangs: its guardian stops it"
                                           : "its driver is gone: its guardian stops it");
}

}  // namespace marco::drivers
