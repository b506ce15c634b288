#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "drivers/hcs12/codec.hpp"

namespace marco::drivers::hcs12 {

/// The sonars of the emulated base board: they fire one after the other in a settable order. A shot
/// is fired, its echo is listened for, the ring rests, and the next one fires.
class SonarSequencer {
 public:
  struct Options {
    SonarForm form = SonarForm::line_each;  ///< the listing's
    double speed_of_sound_m_per_s = 343.0;
  };
  using Range = std::function<double(std::size_t transducer)>;  ///< [m]; infinity = no echo

  SonarSequencer(Range range_m, const Options& options);

  void restart();
  void tick();
  /// `S`. Transducers in the order in which they fire.
  void set_order(const Command& command);
  /// `s`. @returns the reply.
  std::string execute(const Command& command);
  bool on() const { return on_; }
  /// Of the countdown that `w` and `q` look at.
  int64_t shots_left() const { return shots_left_; }

 private:
  void take_reading();

  Range range_m_;
  Options options_;
  std::vector<uint32_t> order_;
  std::array<uint32_t, 16> readings_{};
  bool on_ = false;
  std::size_t shot_ = 0;
  uint32_t shot_tick_ = 0;
  uint32_t listen_ms_ = 50;
  uint32_t rest_ms_ = 20;
  int64_t rounds_ = 0;
  int64_t shots_left_ = 0;
};

}  // namespace marco::drivers::hcs12
