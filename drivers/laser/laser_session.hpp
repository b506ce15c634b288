#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/laser/laser_process.hpp"
#include "drivers/process/driver_loop.hpp"

namespace marco::drivers {

/// Steps one laser driver and publishes its scans: lidar_raw_t with the time of every beam first,
/// then planar_lidar_t with the same utime.
class LaserSession final : public DeviceSession {
 public:
  /// Outlives the session.
  struct Outlet {
    process::Bus& bus;
    process::DropCounter& drops;
    const LaserProcess& laser;
    std::optional<LaserProperties>& properties;  ///< kept up to date for SENSOR_INFO
  };

  /// @param stream  the driver's; outlives the session.
  LaserSession(ByteStream& stream, std::unique_ptr<LaserDriver> driver, Outlet outlet);

  void step() override;
  std::string state() const override;
  bool answers() const override { return driver_->answers(); }
  void stop() override { driver_->stop(); }

 private:
  void flush_input();
  void watch(const LaserScan& scan);
  void publish(ArrivedScan& arrived);
  void count_drops();

  ByteStream& stream_;
  std::unique_ptr<LaserDriver> driver_;
  Outlet outlet_;
  std::map<std::string, int64_t> counted_drops_;
  std::vector<float> last_ranges_m_;
  int repetitions_ = 0;  ///< of the same ranges
  std::chrono::steady_clock::time_point last_step_;
};

}  // namespace marco::drivers
