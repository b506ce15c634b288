#include "drivers/laser/laser_session.hpp"

#include <utility>

#include "drivers/laser/regular_scan.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace marco::drivers {
namespace {

using std::chrono::steady_clock;
// Range noise makes every scan differ from the last. Ten equal scans mean a frozen device.
constexpr int kStuckAfter = 10;
// After a stall the kernel's buffers hold bytes of unknown age. kDrain is enough to read them out.
constexpr std::chrono::milliseconds kStall{500}, kDrain{300};

}  // namespace

LaserSession::LaserSession(ByteStream& stream, std::unique_ptr<LaserDriver> driver, Outlet outlet)
    : stream_(stream),
      driver_(std::move(driver)),
      outlet_(outlet),
      last_step_(steady_clock::now()) {
  outlet_.properties = driver_->properties();
}

void LaserSession::step() {
  std::vector<ArrivedScan> scans = driver_->step();
  const auto now = steady_clock::now();
  if (now - std::exchange(last_step_, now) > kStall) {  // most likely while it waited for bytes
    flush_input();
    scans.clear();
  }
  for (ArrivedScan& arrived : scans) publish(arrived);
  count_drops();
  outlet_.properties = driver_->properties();
}

std::string LaserSession::state() const {
  if (repetitions_ < kStuckAfter) return driver_->state();
  return driver_->state() + ", but stuck: repeats the same scan " +
         std::to_string(repetitions_ + 1) + " times";
}

void LaserSession::flush_input() {
  outlet_.drops.count_received();
  outlet_.drops.count("this process stalled: queued input is too old");
  const auto until = steady_clock::now() + kDrain;
  uint8_t old[4096];
  while (steady_clock::now() < until) stream_.read(old, std::chrono::milliseconds(20));
  driver_->on_input_flushed();
  last_step_ = steady_clock::now();
}

void LaserSession::watch(const LaserScan& scan) {
  repetitions_ = scan.ranges_m == last_ranges_m_ ? repetitions_ + 1 : 0;
  if (repetitions_ == 0) last_ranges_m_ = scan.ranges_m;
}

void LaserSession::publish(ArrivedScan& arrived) {
  outlet_.drops.count_received();
  watch(arrived.scan);
  const std::string lidar = channels::lidar_of(outlet_.laser.place.channel);
  lidar_raw_t raw = to_raw_message(arrived.scan);
  if (arrived.intensities.size() == arrived.scan.size()) raw.intensities = arrived.intensities;
  outlet_.bus.publish(channels::raw_channel_of(lidar), raw);
  outlet_.bus.publish(lidar, to_message(regular_scan(arrived.scan)));
  add_latency((wall_now() - arrived.arrival).seconds());
}

void LaserSession::count_drops() {
  for (const auto& [cause, count] : driver_->counts().drops) {
    for (int64_t& counted = counted_drops_[cause]; counted < count; ++counted) {
      outlet_.drops.count_received();
      outlet_.drops.count(cause);
    }
  }
}

}  // namespace marco::drivers
