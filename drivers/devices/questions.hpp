#pragma once

#include <cstdint>
#include <vector>

#include "drivers/devices/kind.hpp"

namespace marco::drivers::devices {

/// Bytes that make one kind of device say what it is, and change nothing in it.
struct Question {
  Kind whom = Kind::silence;
  int baud = 0;
  std::vector<uint8_t> bytes;
  std::vector<uint8_t> afterwards = {};  ///< to whom it was: takes back what was asked for
  bool on_request = false;               ///< only where a person named the port
};

/// A Create or Roomba answers nothing before START, which stops its wheels and ends what it does,
/// so that it is asked on request alone. In the order in which they may be asked of a stranger.
/// None stops, starts or resets anything: a Roomba takes the bytes of Slamtec's stop for its
/// "clean" button, thesis B's boards drive on a lower-case letter with a number, and boot loaders
/// wake at runs of one byte. So there is no stop and no health, no `$`, `!`, `~`, `G`, `M`, `+++`
/// among them.
const std::vector<Question>& questions();
/// Of a line without rates, TCP: what speaks by Ethernet first, then each of the others once.
const std::vector<Question>& network_questions();

/// The rates at which to listen, most likely first.
const std::vector<int>& rates();

}  // namespace marco::drivers::devices
