#include "common/input/rate_watch.hpp"

#include <algorithm>

#include "common/input/input_gates.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco {
namespace {

// The rate is counted over the window, ten scans of the slowest laser; a burst after a stall ends
// sooner than kLastsS.
constexpr double kWindowS = 2.0, kLastsS = 5.0;
constexpr std::size_t kMostStamps = 1000;  // a window of 500 Hz
constexpr double kUsualAgain = 1.2;        // of the usual rate: well below kTooFast
using input_gates::kTooFast;

}  // namespace

bool RateWatch::is_new_sender(const std::string& name, Utime stamp) {
  Channel& channel = channels_[name];
  std::deque<Utime>& stamps = channel.stamps;
  // The stamps of two senders, or of a stalled logger, need not ascend.
  const Utime newest = stamps.empty() ? stamp : std::max(stamp, stamps.back());
  if ((newest - stamp).seconds() > kWindowS) stamps.clear();  // the clock was set back
  stamps.insert(std::upper_bound(stamps.begin(), stamps.end(), stamp), stamp);
  bool whole = false;
  while ((stamps.back() - stamps.front()).seconds() > kWindowS || stamps.size() > kMostStamps) {
    stamps.pop_front();
    whole = true;
  }
  if (!whole || stamps.size() < 4) return false;
  channel.hz = static_cast<double>(stamps.size()) / kWindowS;
  if (channel.usual_hz == 0.0) channel.usual_hz = channel.hz;
  if (channel.too_fast) {
    channel.too_fast = channel.hz > kUsualAgain * channel.usual_hz;
    return false;
  }
  if (channel.hz <= kTooFast * channel.usual_hz + 1.0) {
    channel.fast_since.reset();
    return false;
  }
  // Stamps in bursts seem fast for a moment, too.
  if (!channel.fast_since) channel.fast_since = newest;
  channel.too_fast = (newest - *channel.fast_since).seconds() >= kLastsS;
  return channel.too_fast;
}

std::string RateWatch::notice() const {
  std::string all;
  for (const auto& [name, channel] : channels_) {
    if (!channel.too_fast) continue;
    all += (all.empty() ? "" : "; ") +
           format("%s: scans at %.0f Hz instead of %.0f Hz: is there a second sender?",
                  name.substr(0, 60).c_str(), channel.hz, channel.usual_hz);
  }
  return all;
}

}  // namespace marco
