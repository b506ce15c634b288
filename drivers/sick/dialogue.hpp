#pragma once

#include <string>

#include "drivers/sick/options.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::drivers::sick {

/// What the driver does, in this order.
enum class Phase {
  finding,
  changing_baud,
  settling,
  checking_baud,
  asking_type,
  asking_status,
  setting_variant,
  reading_configuration,
  entering_installation,
  configuring,
  leaving_installation,
  starting,
  measuring,
};

/// The setup as requests and replies: what to ask in each phase, how to read the answer, which
/// phase comes next. Writes the laser's EEPROM only where its configuration differs.
class Dialogue {
 public:
  static constexpr Duration kModePatience = Duration::from_us(3'200'000);

  explicit Dialogue(const SickOptions& options) : options_(options) {}

  Bytes request(Phase phase, int goal_baud) const;
  /// How long the laser may take to reply.
  Duration patience(Phase phase, int baud) const;

  enum class Answer { other, accepted, refused };
  /// @returns other when the telegram does not answer the phase's request.
  Answer read(Phase phase, const Event& event);
  Phase next(Phase phase, bool at_goal_baud) const;

  void note_type(std::span<const uint8_t> text) { type_.assign(text.begin(), text.end()); }
  const std::string& type() const { return type_; }
  bool defect() const { return defect_; }

 private:
  static uint8_t reply_code(Phase phase);
  bool accept(const Event& event);

  SickOptions options_;
  Configuration wanted_;
  bool configured_ = false;  ///< as wanted already
  std::string type_;
  bool defect_ = false;
};

}  // namespace marco::drivers::sick
