#pragma once

#include "simulator/devices/leuze/emulator.hpp"

namespace marco::drivers::leuze {

/// Thesis A's service in front of the laser. A client connects, sends 1, gets the ranges of the
/// last complete sweep and closes. Other requests are not answered.
class LeuzeServiceEmulator final : public Emulator {
 public:
  LeuzeServiceEmulator(LaserWorld world, const LeuzeGeometry& geometry);

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  int64_t scans_sent() const { return scans_sent_; }
  Utime last_first_beam() const { return last_first_beam_; }

 private:
  LaserWorld world_;
  LeuzeGeometry geometry_;
  Bytes asked_;
  PacedOutput output_;
  int64_t scans_sent_ = 0;
  Utime last_first_beam_;
};

}  // namespace marco::drivers::leuze
