// Alone in this file because the kernel's termios2, which knows every baud rate, and the C
// library's <termios.h> define the same names.
#include <asm/termbits.h>
#include <sys/ioctl.h>

#include "drivers/transport/serial_stream.hpp"

namespace marco::drivers {

int baud_of_terminal(int fd) {
  termios2 settings{};
  if (ioctl(fd, TCGETS2, &settings) != 0) return 0;
  return static_cast<int>(settings.c_ospeed);
}

bool takes_keys(int fd) {
  termios2 settings{};
  return ioctl(fd, TCGETS2, &settings) == 0 && (settings.c_lflag & ISIG) != 0;
}

bool set_terminal(int fd, const LineSettings& line) {
  termios2 settings{};
  if (ioctl(fd, TCGETS2, &settings) != 0) return false;
  settings.c_iflag = line.parity == Parity::none ? 0 : INPCK;
  settings.c_oflag = 0;
  settings.c_lflag = 0;
  settings.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
  if (line.parity != Parity::none) settings.c_cflag |= PARENB;
  if (line.parity == Parity::odd) settings.c_cflag |= PARODD;
  settings.c_ispeed = settings.c_ospeed = static_cast<speed_t>(line.baud);
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  return ioctl(fd, TCSETSW2, &settings) == 0;
}

}  // namespace marco::drivers
