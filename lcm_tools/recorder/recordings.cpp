#include "lcm_tools/recorder/recordings.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <system_error>
#include <tuple>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::recorder {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMarker =
    ".marco-recording";  // its number and its name; locked while it runs
constexpr const char* kKept = ".marco-keep";

/// Of live.lcm.07: 7. Nothing for other files, and for links, which may lead anywhere.
std::optional<int64_t> piece_number(const fs::directory_entry& file) {
  const std::string name = file.path().filename(), head = std::string(kPiece) + ".";
  const bool is_piece = name.starts_with(head) && name.size() > head.size() &&
                        name.size() < head.size() + 10 &&
                        name.find_first_not_of("0123456789", head.size()) == std::string::npos;
  if (!is_piece || file.is_symlink() || !file.is_regular_file()) return std::nullopt;
  return std::stoll(name.substr(head.size()));
}

int lock_of(const fs::path& folder) {
  return open((folder / kMarker).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
}

bool is_running(const fs::path& folder) {
  const int lock = lock_of(folder);
  if (lock < 0) return false;
  const bool held = flock(lock, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(lock);
  return held;
}

std::optional<Recording> read_recording(const fs::path& folder) {
  std::ifstream marker(folder / kMarker);
  Recording recording;
  recording.folder = folder;
  std::string name;
  if (!(marker >> recording.number >> name)) return std::nullopt;
  if (name != folder.filename()) recording.kept = "renamed";
  for (const fs::directory_entry& file : fs::directory_iterator(folder)) {
    const std::string file_name = file.path().filename();
    if (piece_number(file)) {
      recording.bytes += static_cast<int64_t>(file.file_size());
    } else if (file_name != kMarker && file_name != kKept) {
      recording.kept = "holds other files";
    }
  }
  if (fs::exists(folder / kKept)) recording.kept = "kept";
  recording.running = is_running(folder);
  return recording;
}

std::optional<Utime> last_event(const fs::path& piece) {
  files::EventLogReader reader(piece);
  // From near its end, and from farther off where the last events are large.
  for (int64_t back = 1 << 20;; back *= 16) {
    reader.seek(std::max(int64_t{0}, reader.size_bytes() - back));
    std::optional<Utime> last;
    while (const auto head = reader.next_head()) last = head->event_time;
    if (last || back >= reader.size_bytes()) return last;
  }
}

}  // namespace

std::vector<Recording> recordings_in(const fs::path& home) {
  std::vector<Recording> found;
  if (!fs::exists(home)) return found;
  for (const fs::directory_entry& entry : fs::directory_iterator(home)) {
    if (entry.is_symlink() || !entry.is_directory()) continue;
    try {
      if (auto recording = read_recording(entry.path())) found.push_back(std::move(*recording));
    } catch (const fs::filesystem_error&) {  // not ours to read, or deleted meanwhile
    }
  }
  std::sort(found.begin(), found.end(), [](const Recording& a, const Recording& b) {
    return std::tie(a.number, a.folder) < std::tie(b.number, b.folder);
  });
  return found;
}

std::vector<fs::path> pieces_of(const fs::path& recording) {
  std::vector<std::pair<int64_t, fs::path>> numbered;
  for (const fs::directory_entry& file : fs::directory_iterator(recording)) {
    if (const auto number = piece_number(file)) numbered.emplace_back(*number, file.path());
  }
  std::sort(numbered.begin(), numbered.end());
  std::vector<fs::path> pieces;
  pieces.reserve(numbered.size());
  for (auto& [number, path] : numbered) pieces.push_back(std::move(path));
  return pieces;
}

std::optional<double> length_s(const fs::path& recording) {
  std::optional<Utime> first, last;
  for (const fs::path& piece : pieces_of(recording)) {
    if (!first) {
      if (const auto head = files::EventLogReader(piece).next_head()) first = head->event_time;
    }
    if (const auto newest = last_event(piece)) last = newest;
  }
  if (!first || !last) return std::nullopt;
  return (*last - *first).seconds();
}

void keep(const fs::path& recording, Keep keep) {
  require(fs::exists(recording / kMarker),
          recording.string() + " is not a recording of the recorder");
  if (keep == Keep::forever) {
    files::write_whole_file(recording / kKept, "");
  } else {
    fs::remove(recording / kKept);
  }
}

std::string keep_newest(const fs::path& home) {
  const std::vector<Recording> all = recordings_in(home);
  require(!all.empty(), "there is no recording in " + home.string());
  keep(all.back().folder, Keep::forever);
  return all.back().folder.filename();
}

void remove(const Recording& recording) {
  for (const fs::path& piece : pieces_of(recording.folder)) fs::remove(piece);
  fs::remove(recording.folder / kMarker);  // last: who is killed before leaves a recording
  fs::remove(recording.folder);
}

fs::path default_home() {
  const char* run = std::getenv("MARCO_RUN");
  return fs::path(run == nullptr ? "" : run) / "recordings";
}

RunningRecording::RunningRecording(const fs::path& home, std::time_t now) {
  fs::create_directories(home);
  const std::vector<Recording> all = recordings_in(home);
  const int64_t number = all.empty() ? 1 : all.back().number + 1;
  std::tm local = {};
  localtime_r(&now, &local);
  char time[32];
  std::strftime(time, sizeof time, "%Y-%m-%d_%H-%M-%S", &local);
  // The clock may have said so before.
  folder_ = home / time;
  for (int again = 2; !fs::create_directory(folder_); ++again) {
    folder_ = home / (std::string(time) + "_" + std::to_string(again));
  }
  files::write_whole_file(folder_ / kMarker, std::to_string(number) + " " + name() + "\n");
  lock_ = lock_of(folder_);  // children inherit it
  if (lock_ < 0) throw std::runtime_error((folder_ / kMarker).string() + ": cannot be opened");
  flock(lock_, LOCK_EX | LOCK_NB);  // not every file system can
}

RunningRecording::~RunningRecording() { close(lock_); }

int64_t reserve_bytes(const DiskSpace& disk) {
  return std::min(disk.total_bytes / 10, int64_t{5'000'000'000});
}

std::vector<Recording> in_the_way(const std::vector<Recording>& all, const DiskSpace& disk) {
  int64_t missing = reserve_bytes(disk) - disk.free_bytes;
  std::vector<Recording> oldest;
  for (const Recording& recording : all) {
    if (missing <= 0) break;
    if (!recording.may_go()) continue;
    missing -= recording.bytes;
    oldest.push_back(recording);
  }
  return missing <= 0 ? oldest : std::vector<Recording>{};
}

}  // namespace marco::recorder
