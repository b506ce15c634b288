#include "teleop/terminal.hpp"

#include <poll.h>
#include <unistd.h>

#include <stdexcept>

namespace marco::teleop {

Keyboard::Keyboard() : terminal_(isatty(STDIN_FILENO) == 1) {
  if (!terminal_) return;
  tcgetattr(STDIN_FILENO, &before_);
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // signals stay: Ctrl-C is SIGINT
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

Keyboard::~Keyboard() {
  if (terminal_) tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

std::optional<char> Keyboard::key() {
  if (!terminal_) return std::nullopt;
  pollfd input{STDIN_FILENO, POLLIN, 0};
  char buffer[16];
  if (poll(&input, 1, 0) > 0) {
    const ssize_t count = read(STDIN_FILENO, buffer, sizeof(buffer));
    if (count > 0) pending_.append(buffer, static_cast<std::size_t>(count));
    if (count <= 0 && (input.revents & POLLHUP) != 0) {
      throw std::runtime_error("the terminal was closed");
    }
  }
  if (pending_.empty()) return std::nullopt;
  if (pending_.size() >= 3 && pending_[0] == '\x1b' && pending_[1] == '[') {
    static constexpr char kArrows[] = {kUp, kDown, kRight, kLeft};
    const char arrow = pending_[2];
    pending_.erase(0, 3);
    return arrow >= 'A' && arrow <= 'D' ? kArrows[arrow - 'A'] : ' ';
  }
  const char key = pending_[0];
  pending_.erase(0, 1);
  return key;
}

}  // namespace marco::teleop
