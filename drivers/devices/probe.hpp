#pragma once

#include <functional>
#include <string>

#include "drivers/devices/kind.hpp"
#include "drivers/laser/laser_driver.hpp"
#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers::devices {

enum class Manner {
  listen,   ///< not a byte is sent
  ask,      ///< what is silent, or sends bytes that nobody knows, is asked; text is let alone
  ask_all,  ///< the same with the questions that are asked on request
};

enum class Reach {
  serial,   ///< at every rate
  network,  ///< TCP: there are no rates
};

/// What is at the other end of a line.
struct Finding {
  Claim claim;
  int baud = 0;              ///< at which it was understood, or made most sense; 0 on TCP
  double bytes_per_s = 0.0;  ///< that came unasked
  bool echoes = false;       ///< what is sent comes back: a terminal, a modem, or a wire
};

/// Listens at every rate, then asks (questions()). Takes 6 s of listening to a silent line, 18 s to
/// a stranger's, and 4 s of asking. @throws StreamLost.
Finding probe(ByteStream& stream, const Clock& clock, Manner manner, Reach reach = Reach::serial);

}  // namespace marco::drivers::devices
