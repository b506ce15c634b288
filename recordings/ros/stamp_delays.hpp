#pragma once

#include <cstdint>
#include <map>

namespace marco::ros {

/// The times from a sender's stamps to the recorder, which tell its clock from others': the least
/// of every five seconds, that no queue adds to. They grow where time is simulated slowly.
class StampDelays {
 public:
  void add(int64_t received_ns, int64_t stamp_ns);
  bool empty() const { return least_s_.empty(); }
  /// [s]; 0 where nothing is known.
  double least_s() const;
  /// By how much longer they are than another sender's of the same time: its clock is ahead of
  /// this one by so much.
  double longer_s(const StampDelays& other) const;

 private:
  std::map<int64_t, double> least_s_;  // by the part of the recording
};

}  // namespace marco::ros
