#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lcm_tools/diagnosis/datagram.hpp"
#include "lcm_tools/diagnosis/network.hpp"

namespace marco::diagnosis {

/// A channel on the bus, with its last message.
struct HeardChannel {
  std::string name;
  uint64_t fingerprint = 0;  ///< 0: the message was shorter than one
  int64_t messages = 0;
  double hz = 0.0;
  /// This host's clock less the stamp in the message's first field [s]. Nothing where the field is
  /// not a stamp of this century.
  std::optional<double> stamp_age_s;
};

/// The traffic of other programs on a bus within some seconds.
struct BusSurvey {
  std::vector<HeardChannel> channels;  ///< by name
  /// By process: its state on PROCESS_STATUS, where that begins with process::kNoDevice.
  std::map<std::string, std::string> troubles;
  std::vector<Finding> network;  ///< see diagnose()
};

/// Counts datagrams: a name, eight bytes and a stamp each.
class SurveyCounter {
 public:
  /// @param program  that asks. Its own traffic, known by its PROCESS_STATUS, is left out.
  explicit SurveyCounter(std::string program) : program_(std::move(program)) {}

  void add(int64_t time_us, const Address& sender, std::span<const uint8_t> datagram);
  /// @param listened_s  how long, for rates.
  BusSurvey result(double listened_s) const;

 private:
  void take_status(const Address& sender, std::span<const uint8_t> message);

  std::string program_;
  std::set<Address> own_;
  std::map<std::pair<std::string, Address>, HeardChannel> channels_;
  std::map<std::string, std::string> troubles_;
};

/// Listens to all channels of `url` for `seconds` (less when `stop` becomes true), on a socket of
/// its own. Where nothing is received it looks for the reason, for up to a second more.
/// @param program  that asks, for the commands in the remedy.
BusSurvey survey_bus(const UdpUrl& url,
                     const std::string& program,
                     double seconds,
                     const std::atomic<bool>& stop);

/// "bot_core.planar_lidar_t", or "" for the fingerprint of an unknown type.
std::string type_name(uint64_t fingerprint);

/// The stamp [us], the first field of most types; nothing when the message is too short.
std::optional<int64_t> stamp_at_head(std::span<const uint8_t> message);

}  // namespace marco::diagnosis
