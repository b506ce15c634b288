#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lcm_tools/log/log_info.hpp"
#include "lcm_tools/log/log_walk.hpp"

namespace marco::logs {

/// A message that an MCAP export adds to the original.
struct AddedMessage {
  std::string topic;   ///< "LIDAR/LaserScan"
  std::string schema;  ///< "foxglove.LaserScan"
  std::string json;
  std::optional<Utime> event_time = {};  ///< when it differs from the translated event's
};

/// Translates the messages of a log into the vocabulary of a viewer.
class McapTranslator {
 public:
  virtual ~McapTranslator() = default;
  /// What to write for this event and for earlier ones that waited for it.
  virtual std::vector<AddedMessage> translate(const DecodedEvent& event) = 0;
  /// What still waits at the end of the log.
  virtual std::vector<AddedMessage> finish() = 0;
  /// The JSON Schema of a schema that translate() named.
  virtual std::string json_schema(const std::string& schema) const = 0;
  /// One line for the user about what could not be translated; "" = nothing.
  virtual std::string remark() const { return ""; }
};

/// @param log inspect_log of the log, without the channels that are left out
using MakeMcapTranslator = std::function<std::unique_ptr<McapTranslator>(const LogInfo& log)>;

}  // namespace marco::logs
