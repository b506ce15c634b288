#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/laser_scan.hpp"

namespace marco {

/// In which order a laser that sees all round measures its beams: first to last, the other way
/// round, or, as no real one does, all at once.
enum class BeamOrder : int32_t { forwards, backwards, at_once };

/// What a judge of beam orders concludes for a scan.
struct BeamVerdict {
  /// The order that scans are put into; nothing: they are left as they are.
  std::optional<BeamOrder> order;
  /// The other two; empty when they are no longer judged.
  std::vector<BeamOrder> rivals;

  template <class Visitor>
  void visit(Visitor& v) {
    v("order", order);
    v("rivals", rivals);
  }
};

/// The times of a scan's beams, one a beam, in another order than theirs. Times that span a turn
/// keep their span. Others are spread evenly over the period from the time on that they all have:
/// drivers and ROS (sensor_msgs/LaserScan) stamp a scan with its first beam.
/// @param now  the order of the scan's times
std::vector<float> reordered_times_s(const LaserScan& scan,
                                     double period_s,
                                     BeamOrder now,
                                     BeamOrder order);

/// Finds the order of a laser's beams by what scans show: in a wrong order walls bend when the
/// robot turns. It judges until it is sure, or until as many turning scans as it takes have not
/// told. Not thread-safe.
///
/// The map that scans are compared with was made in the present order, and favours it. From scans
/// taken to be measured at once both other orders are equally far off, and are compared with each
/// other; else a rival has to be better than the present one in spite of that.
class BeamOrderJudge {
 public:
  /// Puts the scan's beam times into the order found, if another one than theirs was found.
  /// @param period_s  between scans; 0 = not known yet
  BeamVerdict look(LaserScan& scan, double period_s);

  /// Takes note of a turning scan.
  /// @param misfits_m2  mean squared residuals: of the scan as it is, then of its rivals, as many
  /// @returns whether this changes the order that scans are put into.
  bool note(const BeamVerdict& scan, const std::vector<double>& misfits_m2);

  /// That scans are put into.
  BeamOrder present() const { return present_; }
  /// What was found and is done, for a person.
  std::string description() const;

  template <class Visitor>
  void visit(Visitor& v) {
    v("sums", sums_);
    v("scans", scans_);
    v("given", given_);
    v("present", present_);
    v("decided", decided_);
  }

 private:
  /// Over the turning scans.
  struct Sums {
    double sum = 0.0, squares = 0.0;

    template <class Visitor>
    void visit(Visitor& v) {
      v("sum", sum);
      v("squares", squares);
    }
  };

  /// In standard deviations of the mean.
  double sigmas(const Sums& sums) const;
  std::optional<std::size_t> better_rival() const;
  std::vector<BeamOrder> rivals() const;

  /// Of log(misfit of the present order / misfit of a rival), and of the first rival's less the
  /// second's.
  std::vector<Sums> sums_ = std::vector<Sums>(3);
  int32_t scans_ = 0;
  std::optional<BeamOrder> given_;  ///< by the first scan's times
  BeamOrder present_ = BeamOrder::at_once;
  bool decided_ = false;
};

}  // namespace marco
