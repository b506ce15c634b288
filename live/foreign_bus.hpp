#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lcm_tools/files/channel_pattern.hpp"
#include "lcm_tools/process/command_line.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "recordings/foreign_messages.hpp"

namespace marco {

/// Adds `--foreign FILE`, which stays in `path`; "" is the table that is compiled in.
inline process::Option add_foreign_argument(process::CommandLine& app, std::string& path) {
  return app
      .add_option("--foreign", path,
                  "TOML file with the meaning of other systems' channels: see config/foreign.toml")
      .existing_file();
}

/// The network, with other systems' sensors translated as if they were Marco's: their messages come
/// to the handlers of LIDAR, LIDAR_RAW, ODOMETRY and SENSOR_INFO, translated by the table of
/// foreign channels, and to nobody else. Nothing of it goes out to the network. The first foreign
/// laser and the first foreign odometry to arrive are used, and no laser once SENSOR_INFO announces
/// one of ours. A type of ours on its own channel is never foreign: a driver of ours says where its
/// laser sits, and scans are not used before.
class ForeignBus : public process::Bus {
 public:
  /// @param bus  outlives this one.
  /// @param say  called once for each channel used, with its meaning.
  ForeignBus(process::LcmBus& bus, ForeignTable table, std::function<void(const std::string&)> say);

  void subscribe_raw(const std::string& channel_regex, RawHandler handler) override;
  void publish_raw(const std::string& channel,
                   std::span<const uint8_t> bytes,
                   Utime utime) override {
    bus_.publish_raw(channel, bytes, utime);
  }
  std::map<std::string, int64_t> lost() const override { return bus_.lost(); }
  int64_t lost_datagrams() const override { return bus_.lost_datagrams(); }

  /// The channels that are used, with the fingerprints of their types.
  std::vector<std::pair<std::string, std::string>> used() const;
  /// Messages that could not be translated, by cause.
  const process::DropCounter& drops() const { return drops_; }

 private:
  /// A channel with the type of its messages.
  using Key = std::pair<std::string, std::string>;
  struct Foreign {
    const ForeignChannel* entry = nullptr;  // nullptr: it means nothing to us
    bool is_used = false;
  };

  bool may_be_foreign(std::span<const uint8_t> bytes) const;
  bool is_used(const process::RawMessage& raw) const;
  void take(const process::RawMessage& raw);
  bool may_be_used(const Foreign& channel) const;
  void use(const Key& key, Foreign& channel);
  void announce(const LaserScan& scan, const ForeignChannel& entry, Utime now);
  void deliver(const Sample& sample, Utime now);

  process::LcmBus& bus_;
  ForeignTable table_;
  std::function<void(const std::string&)> say_;
  process::DropCounter drops_;
  std::set<std::string> types_;  // fingerprints of the table
  std::map<Key, Foreign> channels_;
  std::set<std::string> meanings_;  // "lidar", "odometry": those that are used
  bool has_own_laser_ = false;
  std::optional<Utime> announced_;
  ForeignMessages messages_;
  std::vector<std::pair<ChannelPattern, RawHandler>> handlers_;
};

}  // namespace marco
