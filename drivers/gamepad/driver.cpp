#include "drivers/gamepad/driver.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <thread>

namespace marco::drivers::gamepad {

void GamepadDriver::try_to_open(Utime now) {
  next_try_ = now + Duration::from_seconds(1.0);
  struct stat info {};
  if (stat(path_.c_str(), &info) != 0) return;
  fifo_ = S_ISFIFO(info.st_mode);
  // A FIFO is held open for writing too, so that its writers may come and go.
  file_.reset(::open(path_.c_str(), (fifo_ ? O_RDWR : O_RDONLY) | O_NONBLOCK | O_CLOEXEC));
  reader_.clear();
}

std::vector<GamepadState> GamepadDriver::step(int timeout_ms, Utime now) {
  std::vector<GamepadState> states;
  if (!file_.valid() && now >= next_try_) try_to_open(now);
  if (!file_.valid()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
    return states;
  }
  pollfd input{file_.get(), POLLIN, 0};
  if (poll(&input, 1, timeout_ms) <= 0) return states;
  std::array<uint8_t, 512> buffer;
  const ssize_t count = read(file_.get(), buffer.data(), buffer.size());
  if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) {
    file_.reset();
    model_.disconnect(now);
    states.push_back(model_.state());
    return states;
  }
  if (count < 0) return states;
  reader_.push({buffer.data(), static_cast<std::size_t>(count)});
  bool changed = false;
  while (const auto event = reader_.next()) {
    model_.apply(*event, now);
    changed = true;
  }
  if (changed) states.push_back(model_.state());
  return states;
}

}  // namespace marco::drivers::gamepad
