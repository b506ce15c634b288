#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "lcm_tools/procman/wire.hpp"

namespace marco::procman {

/// What deputy and keeper say to each other over a SOCK_SEQPACKET socket, one message a packet:
///
///     deputy -> keeper  run      the command, its run id and its output file; once
///                       stop     signal, and seconds until SIGKILL
///                       shown    how far the output has been published
///                       release  the deputy knows the exit status: the keeper may go
///     keeper -> deputy  state    all of the above and the pid; after run, and to a deputy that
///                                comes back
///                       grew     how long the output file is now
///                       ended    raw wait status; the whole tree is gone, the output complete
struct KeeperMessage {
  std::string kind;
  CommandSpec spec;
  int32_t runid = 0;
  int32_t pid = 0;
  int raw_status = 0;
  std::string cause;  ///< why the keeper itself killed the command, if it did
  int signal = 0;
  double allowed_s = 0.0;
  std::string output_file;
  int64_t output_limit = 0;  ///< a longer file becomes output_file.1, and a new one begins
  int64_t output_inode =
      0;  ///< of the file that is written now: another one after each such change
  int64_t output_begin = 0;  ///< length of the first file when the run began
  int64_t output_end = 0;    ///< length now
  int64_t output_shown = 0;  ///< published up to here
  int64_t output_lost = 0;   ///< bytes that could not be written: the disk is full

  bool operator==(const KeeperMessage&) const = default;
};

/// Lines "key value"; text values are escaped.
std::string encode(const KeeperMessage& message);

/// @returns none for what encode() did not write.
std::optional<KeeperMessage> decode_keeper_message(std::string_view bytes);

/// No message is longer: sockets and readers count on it.
inline constexpr std::size_t kMaxKeeperMessage = std::size_t{128} * 1024;

}  // namespace marco::procman
