#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/log/select.hpp"

namespace marco::logs {

struct RepairReport {
  struct Mended {
    int64_t number = 0;   ///< of the event, after repair
    int64_t offset = 0;   ///< [byte] in the damaged log
    std::string channel;  ///< after repair
    std::string what;     ///< "sync word", "time" ...
  };
  struct Lost {
    int64_t offset = 0;  ///< [byte] in the damaged log
    int64_t bytes = 0;
  };
  int64_t events = 0;                     ///< written
  int64_t untouched = 0;                  ///< of these, copied unchanged
  std::map<std::string, int64_t> mended;  ///< repaired fields, by kind
  std::vector<Mended> mended_events;      ///< the first 1000
  int64_t lost_places = 0;
  int64_t lost_bytes = 0;
  std::vector<Lost> lost;       ///< the first 1000
  int64_t missing_numbers = 0;  ///< numbers between the first and the last that no event has
  std::map<std::string, int64_t>
      undecodable;  ///< whole events whose message does not decode, by channel
};

enum class Mending { headers, nothing };

/// Whether a message of this type decodes; true for types that are not known.
using Decodes = std::function<bool(std::span<const uint8_t> message)>;

/// Writes every whole event of a damaged log and, unless `mending` is nothing, events with one
/// damaged header field that the surroundings determine: sync word, a length, a byte of the channel
/// or of the fingerprint, event number, event time. Damage inside a message is detected only if the
/// message no longer decodes: such events are kept and counted. Reads the log twice.
/// @throws std::invalid_argument or std::runtime_error as EventLogReader and OutputFile.
RepairReport repair_log(const std::filesystem::path& in,
                        OutputFile& out,
                        Mending mending,
                        const Decodes& decodes,
                        const OnProgress& on_progress);

/// For the user.
std::string to_text(const RepairReport& report);
std::string to_json(const RepairReport& report);

}  // namespace marco::logs
