#include "lcm_tools/log/keys.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <string_view>
#include <utility>

namespace marco::logs {
namespace {

constexpr std::array<std::pair<std::string_view, Key>, 28> kKeys = {{
    {" ", Key::pause},          {"p", Key::pause},
    {"s", Key::step},           {".", Key::step},
    {"\x1b[D", Key::back},      {"\x1bOD", Key::back},
    {"\x1b[C", Key::forward},   {"\x1bOC", Key::forward},
    {"\x1b[5~", Key::far_back}, {"\x1b[6~", Key::far_forward},
    {"\x1b[H", Key::start},     {"\x1bOH", Key::start},
    {"\x1b[1~", Key::start},    {"0", Key::start},
    {"\x1b[A", Key::faster},    {"\x1bOA", Key::faster},
    {"+", Key::faster},         {"\x1b[B", Key::slower},
    {"\x1bOB", Key::slower},    {"-", Key::slower},
    {"1", Key::normal_speed},   {"l", Key::loop},
    {"[", Key::loop_start},     {"]", Key::loop_end},
    {"\\", Key::loop_clear},    {"h", Key::help},
    {"?", Key::help},           {"q", Key::quit},
}};

}  // namespace

const char* const kKeysHelp =
    "space pause   s step   left/right 5 s   PgUp/PgDn 1 min   0 start   up/down speed   1 speed "
    "1\n"
    "l loop   [ ] loop from/to here   \\ loop over all   q quit\n";

Key take_key(std::string& typed) {
  while (!typed.empty()) {
    for (const auto& [bytes, key] : kKeys) {
      if (!typed.starts_with(bytes)) continue;
      typed.erase(0, bytes.size());
      return key;
    }
    const bool begun = std::any_of(kKeys.begin(), kKeys.end(), [&](const auto& entry) {
      return typed.size() < entry.first.size() && entry.first.starts_with(typed);
    });
    if (begun) return Key::none;
    typed.erase(0, 1);
  }
  return Key::none;
}

Keyboard::Keyboard(Use use) {
  there_ = use == Use::keys && isatty(STDIN_FILENO) == 1 && tcgetattr(STDIN_FILENO, &before_) == 0;
  if (!there_) return;
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

Keyboard::~Keyboard() {
  if (there_) tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

std::string Keyboard::wait(int64_t timeout_us) {
  pollfd keyboard = {STDIN_FILENO, POLLIN, 0};
  const int64_t us = std::max<int64_t>(0, timeout_us);
  const timespec timeout = {static_cast<time_t>(us / 1000000),
                            static_cast<long>(us % 1000000 * 1000)};
  const nfds_t watched = there_ ? 1 : 0;
  if (ppoll(&keyboard, watched, &timeout, nullptr) <= 0) return "";
  char bytes[64];
  const ssize_t got = read(STDIN_FILENO, bytes, sizeof bytes);
  if (got <= 0) {
    there_ = false;  // the terminal is gone: play on without keys
    return "";
  }
  return {bytes, static_cast<std::size_t>(got)};
}

}  // namespace marco::logs
