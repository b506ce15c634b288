#include "drivers/gamepad/driver.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <thread>

#include "drivers/transport/port_advice.hpp"

namespace marco::drivers::gamepad {

void GamepadDriver::try_to_open(Utime now) {
  next_try_ = now + Duration::from_seconds(1.0);
  struct stat info {};
  if (stat(path_.c_str(), &info) != 0) {
    trouble_ = why_not_open(path_, errno, DeviceKind::gamepad);
    return;
  }
  fifo_ = S_ISFIFO(info.st_mode);
  file_.reset(::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  trouble_ = file_.valid() ? "" : why_not_open(path_, errno, DeviceKind::gamepad);
  reader_.clear();
}

GamepadState GamepadDriver::lose(Utime now) {
  file_.reset();
  told_.reset();
  model_.disconnect(now);
  return model_.state();
}

std::optional<GamepadState> GamepadDriver::leave(Utime now) {
  if (!told_) return std::nullopt;
  return lose(now);
}

std::vector<GamepadState> GamepadDriver::step(int timeout_ms, Utime now) {
  std::vector<GamepadState> states;
  if (!file_.valid() && now >= next_try_) try_to_open(now);
  if (!file_.valid()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
    return states;
  }
  const auto repeat = [&] {
    if (!told_ || (now - *told_).seconds() < kRepeatS) return;
    told_ = now;
    states.push_back(model_.state());
    states.back().utime = now;
  };
  pollfd input{file_.get(), POLLIN, 0};
  if (poll(&input, 1, timeout_ms) <= 0) {
    repeat();
    return states;
  }
  std::array<uint8_t, 512> buffer;
  const ssize_t count = read(file_.get(), buffer.data(), buffer.size());
  if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) {
    states.push_back(lose(now));
    if (fifo_) try_to_open(now);
    return states;
  }
  if (count > 0) reader_.push({buffer.data(), static_cast<std::size_t>(count)});
  bool changed = false;
  while (const auto event = reader_.next()) {
    model_.apply(*event, now);
    changed = true;
  }
  if (changed) {
    told_ = now;
    states.push_back(model_.state());
  } else {
    repeat();
  }
  return states;
}

}  // namespace marco::drivers::gamepad
