#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "slam/localization/saved_map.hpp"
#include "slam/process/mapper2d_adapter.hpp"

namespace marco::slam {

/// What a SlamAdapter knows: resumed from it, it continues as if it had never died.
struct AdapterState {
  SavedMap map;
  SynchronizerState input;
  MappingProgress progress;
  int64_t received = 0;
  std::map<std::string, int64_t> drops;

  template <class Visitor>
  void visit(Visitor& v) {
    v("map", map);
    v("input", input);
    v("progress", progress);
    v("received", received);
    v("drops", drops);
  }
};

std::string encode_adapter_state(const AdapterState& state);
/// @throws std::invalid_argument as decode_saved_map.
AdapterState decode_adapter_state(std::string_view bytes);

/// Writes `path` as a whole; what it held is kept as `path`.before.
/// @throws std::runtime_error naming the path.
void save_adapter_state(const std::filesystem::path& path, const AdapterState& state);

/// The newest whole checkpoint: `path`, or the one before where that is damaged or missing; nothing
/// when there is none. @param warn  called with the fault of a file that was not used
std::optional<AdapterState> load_adapter_state(const std::filesystem::path& path,
                                               const std::function<void(const std::string&)>& warn);

/// When it was written, as a part of file names: 2026-11-28_14-03-22, local time.
std::string time_of(const std::filesystem::path& checkpoint);

/// Renames `path` and the one before to names with their times, where they exist.
/// @param warn  called with that
void put_checkpoint_aside(const std::filesystem::path& path,
                          const std::function<void(const std::string&)>& warn);

/// Its process ended in order: `path`.ended is there until the next save.
void mark_ended(const std::filesystem::path& path);

/// Held by the process that reads and writes `path`, until its end.
class CheckpointLock {
 public:
  /// @throws std::runtime_error when another process holds it
  explicit CheckpointLock(const std::filesystem::path& path);
  ~CheckpointLock();
  CheckpointLock(const CheckpointLock&) = delete;
  CheckpointLock& operator=(const CheckpointLock&) = delete;

 private:
  int lock_;
};

}  // namespace marco::slam
