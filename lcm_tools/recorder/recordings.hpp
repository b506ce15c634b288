#pragma once

#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// Recordings on the disk: a folder for each, named by its local time, with its pieces live.lcm.00,
/// live.lcm.01, ... in it, and a marker that the recorder wrote. All throw
/// std::filesystem::filesystem_error or std::runtime_error that names the path. One thread.
namespace marco::recorder {

inline constexpr const char* kPiece = "live.lcm";  ///< and a dot, and a number

struct Recording {
  std::filesystem::path folder;
  int64_t number = 0;  ///< in the order of their beginnings, whatever the clock said
  int64_t bytes = 0;
  bool running = false;  ///< a recorder, or the logger that it left, still writes
  /// Why it is never deleted: "kept", "renamed", "holds other files"; "" = it may be.
  std::string kept;

  bool may_go() const { return !running && kept.empty(); }
};

/// Those in `home`, oldest first. Folders without a marker are none.
std::vector<Recording> recordings_in(const std::filesystem::path& home);

/// What is in a recording: its pieces, in their order.
std::vector<std::filesystem::path> pieces_of(const std::filesystem::path& recording);

/// From its first to its last event [s]; nothing when there is none.
std::optional<double> length_s(const std::filesystem::path& recording);

/// It is never deleted from here on; or may be again. @throws std::invalid_argument when
/// `recording` is none.
enum class Keep { forever, until_room_is_needed };
void keep(const std::filesystem::path& recording, Keep keep);

/// Marks the newest one as kept. @throws std::invalid_argument when there is none.
/// @returns its name
std::string keep_newest(const std::filesystem::path& home);

/// Its pieces and its marker; whatever else came into it stays.
void remove(const Recording& recording);

/// $MARCO_RUN/recordings, or ./recordings.
std::filesystem::path default_home();

/// A recording that runs: nobody deletes it while this object, or a child process, lives.
class RunningRecording {
 public:
  /// Begins one, and makes `home` where there is none. Its name is that of no other.
  RunningRecording(const std::filesystem::path& home, std::time_t now);
  ~RunningRecording();
  RunningRecording(const RunningRecording&) = delete;
  RunningRecording& operator=(const RunningRecording&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  bool is_there() const { return std::filesystem::exists(folder_); }
  std::string name() const { return folder_.filename(); }

 private:
  std::filesystem::path folder_;
  int lock_ = -1;
};

struct DiskSpace {
  int64_t free_bytes = 0;   ///< for who is not root
  int64_t total_bytes = 0;  ///< of the whole disk
};

/// What recordings leave free: a tenth of the disk, at most 5 GB.
int64_t reserve_bytes(const DiskSpace& disk);

/// The oldest ones that must go so that the reserve is free; nothing when it is already, or when
/// all that may go would not suffice.
/// @param all  oldest first
std::vector<Recording> in_the_way(const std::vector<Recording>& all, const DiskSpace& disk);

}  // namespace marco::recorder
