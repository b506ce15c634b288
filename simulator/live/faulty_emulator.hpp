#pragma once

#include <deque>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "simulator/devices/transport/emulator.hpp"
#include "simulator/live/faults.hpp"

namespace marco::sim {

/// A device whose line has faults: off, garbage, slow, intermittent. The faults of its measurements
/// (stuck, wrong) are the robot's part.
class FaultyEmulator final : public drivers::Emulator {
 public:
  /// @param inner, board  outlive it.
  FaultyEmulator(drivers::Emulator& inner, const FaultBoard& board, std::string device)
      : inner_(inner), board_(board), device_(std::move(device)) {}

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

 private:
  bool silent(Utime now) const;
  void spoil(std::vector<uint8_t>& bytes);

  drivers::Emulator& inner_;
  const FaultBoard& board_;
  std::string device_;
  std::mt19937 random_{1};
  std::deque<std::pair<Utime, std::vector<uint8_t>>> late_;
};

}  // namespace marco::sim
