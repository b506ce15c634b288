#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/utf8.hpp"

namespace marco::procman {

/// A part of what goes into one PM_OUTPUT.
struct OutputPiece {
  std::string id;
  std::string text;         ///< UTF-8
  int64_t first_byte = -1;  ///< in the file; -1 = a message of the deputy
  int64_t end_byte = -1;
  std::string file;
};

/// Reads the files that keepers write, and hands out new bytes at a rate that receivers can follow.
/// When a command is far ahead, its oldest bytes are left out; the text says so.
class OutputPump {
 public:
  /// @param bytes_per_s > 0, of all commands together.
  explicit OutputPump(double bytes_per_s);

  /// A run of `id` writes to `file`; bytes before `shown` were handed out already.
  void open_run(const std::string& id, const std::string& file, int64_t shown);

  /// The run has begun a new `file`, with this inode. The rest of the file before is still handed
  /// out, older ones are left out, so that no deleted file stays open for long.
  /// @returns false when the file of this name is another one: call again with newer information.
  bool open_next_file(const std::string& id, const std::string& file, int64_t inode);
  void on_growth(const std::string& id, int64_t end_byte);

  /// A message of the deputy, after the command's output so far. id "" = about no command.
  void tell(const std::string& id, const std::string& line);

  /// The pieces of the next message, commands in turns. Empty when nothing is due.
  std::vector<OutputPiece> take(int64_t now_us);

  /// When there is something to take.
  std::optional<int64_t> next_due_us() const;

  /// Handed out so far of the file that `id` was last read from, and which that is.
  struct Shown {
    int64_t inode = 0;
    int64_t bytes = 0;
  };
  Shown shown(const std::string& id) const;

 private:
  struct Source {
    Descriptor file;  ///< none: `line` is all
    int64_t inode = 0;
    std::string path;
    int64_t at = 0;
    int64_t end = 0;
    std::string line;
  };
  struct Stream {
    std::deque<Source> sources;
    Utf8Cleaner cleaner;
    Shown shown;
  };

  bool has_more(const Stream& stream) const;
  void leave_out_old_bytes(Source& source, std::string& text) const;
  OutputPiece take_piece(const std::string& id, Stream& stream, std::size_t max_bytes);

  double bytes_per_s_;
  std::map<std::string, Stream> streams_;
  std::string last_served_;
  int64_t next_us_ = 0;
};

}  // namespace marco::procman
