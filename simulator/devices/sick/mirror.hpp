#pragma once

#include <array>
#include <optional>
#include <vector>

#include "drivers/sick/codec.hpp"
#include "simulator/devices/laser_world.hpp"

namespace marco::drivers::sick {

/// The measuring half of the emulated laser: when its scans end and what they saw. A scan of 0.5 or
/// 0.25 degrees is made of two or four turns of whole degrees; the world is asked for each turn at
/// its own time.
class SickMirror {
 public:
  struct Variant {
    int angle_deg = 180;
    int resolution_cdeg = 50;
  };
  /// Which values a reply carries.
  struct Form {
    uint8_t mode = kOnRequest;  ///< kContinuous, kMean ...
    uint8_t samples = 0;        ///< scans in a mean
    std::array<uint16_t, 2> sub_range{1, 1};
  };

  SickMirror(LaserWorld world, double turn_s) : world_(std::move(world)), turn_s_(turn_s) {}

  bool turning() const { return start_.us != 0; }
  void start(Utime now) { start_ = now; }
  void set_variant(const Variant& variant) { variant_ = variant; }
  const Variant& variant() const { return variant_; }

  /// Begins scans of this form with the next turn.
  void begin(const Form& form, Utime not_before);
  Utime scan_end() const;
  /// Ends the scan, begins the next. @returns nothing for a scan inside a mean.
  std::optional<MeasuredValues> finish_scan(const Configuration& configuration);
  /// Skips the scans that end before. @returns how many.
  int64_t skip_until(Utime free_at);

  uint8_t turn_index() const { return static_cast<uint8_t>(turn_end_); }
  Utime last_first_beam() const { return last_first_beam_; }

 private:
  int turns_per_scan() const;
  MeasuredValues measure(Utime first_beam, const Configuration& configuration) const;

  LaserWorld world_;
  double turn_s_;
  Utime start_;
  Variant variant_;
  Form form_;
  std::vector<std::vector<uint16_t>> summed_;  ///< scans of the mean under way
  int64_t turn_end_ = 0;  ///< the number of the turn at whose end the next scan ends
  Utime last_first_beam_;
};

}  // namespace marco::drivers::sick
