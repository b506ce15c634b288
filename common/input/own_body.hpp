#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/laser_scan.hpp"
#include "common/pose2.hpp"

namespace marco {

/// A sector in which a laser sees the robot that bears it: a post of its upper deck, a mast, a
/// wheel.
struct BodyPart {
  std::string channel;     ///< of the laser
  double first_deg = 0.0;  ///< bearing in the laser's frame, counter-clockwise from ahead
  double last_deg = 0.0;   ///< counter-clockwise from the first
  double within_m = 0.0;   ///< returns nearer than this are the robot's

  /// Whether a return comes from it. A degree more on either side: beams at an edge return a little
  /// of both.
  bool has(double bearing_rad, float range_m) const;

  template <class Visitor>
  void visit(Visitor& v) {
    v("channel", channel);
    v("first_deg", first_deg);
    v("last_deg", last_deg);
    v("within_m", within_m);
  }
  bool operator==(const BodyPart&) const = default;
};

/// Makes no returns of those that come from the part. @returns how many there were.
std::size_t blank(LaserScan& scan, const BodyPart& part);

/// The bearing in whole degrees from 0 to 359, rounded down.
std::size_t degree_of(double bearing_rad);

/// `the robot itself is in view of LIDAR: 20 to 25 deg, within 0.30 m`, for a person.
std::string describe(const std::vector<BodyPart>& parts);

/// Finds the bearings under which one laser sees its own robot: there the range stays the same to
/// some centimetres while the rest of the scan changes. Only scans count in which much has changed
/// since the last one that counted, so that a robot that stands shows nothing. Along a wall that is
/// followed the range stays the same, too, but the wall continues where the same range ends; beside
/// a part of the robot the view is free. Not thread-safe; its state is some kilobytes.
class OwnBody {
 public:
  /// Takes note of the scan. @returns whether other bearings than before are the robot's now
  bool look(const LaserScan& scan);

  /// What was found, in the order of bearings.
  const std::vector<BodyPart>& parts() const { return parts_; }
  /// How many scans counted.
  int samples() const { return samples_; }

  template <class Visitor>
  void visit(Visitor& v) {
    v("bins", bins_);
    v("last_m", last_m_);
    v("samples", samples_);
    v("parts", parts_);
  }

 private:
  /// A degree of bearing: the range that most of its nearest returns have.
  struct Bin {
    float range_m = 0.0F;
    int32_t same = 0;
    int32_t other = 0;
    int32_t free_before = 0,
            free_after = 0;  ///< of the same: nothing near at the neighbouring bearings

    template <class Visitor>
    void visit(Visitor& v) {
      v("range_m", range_m);
      v("same", same);
      v("other", other);
      v("free_before", free_before);
      v("free_after", free_after);
    }
    /// @param before_m, after_m  nearest returns some degrees to either side
    void note(float nearest_m, float before_m, float after_m);
    bool is_body() const;
  };

  bool has_changed(const std::vector<float>& nearest_m) const;
  /// Neighbouring bearings that may be one part of the robot: first and last bin.
  std::vector<std::array<std::size_t, 2>> sectors() const;
  std::vector<BodyPart> parts_in(const std::string& channel) const;

  std::vector<Bin> bins_;
  std::vector<float> last_m_;  ///< nearest returns of the last scan that counted; 0 = none
  int32_t samples_ = 0;
  std::vector<BodyPart> parts_;
};

}  // namespace marco
