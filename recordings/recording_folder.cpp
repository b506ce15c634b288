#include "recordings/recording_folder.hpp"

#include <algorithm>
#include <iterator>
#include <set>

#include "recordings/recording.hpp"
#include "recordings/ros/open_messages.hpp"
#include "recordings/tilted_scans.hpp"

namespace marco {
namespace {

namespace fs = std::filesystem;

bool is_scan_file(const fs::path& path) {
  return fs::is_regular_file(path) && files::is_tilted_scan(path);
}

std::vector<fs::path> shown_in(const fs::path& folder) {
  std::vector<fs::path> inside;
  const auto skipped = fs::directory_options::skip_permission_denied;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, skipped)) {
    if (!entry.path().filename().string().starts_with('.')) inside.push_back(entry.path());
  }
  std::sort(inside.begin(), inside.end());
  return inside;
}

// A link may lead to a folder that was seen.
std::vector<RecordingParts> recordings_below(const fs::path& folder, std::set<fs::path>& seen) {
  if (!seen.insert(fs::canonical(folder)).second || fs::exists(folder / "report.json")) return {};
  if (!ros::parts_by_metadata(folder).empty()) return {{folder}};
  const std::vector<fs::path> inside = shown_in(folder);
  const bool has_messages = std::any_of(inside.begin(), inside.end(), ros::is_message_file);
  if (!has_messages && std::any_of(inside.begin(), inside.end(), is_scan_file)) return {{folder}};
  std::vector<fs::path> known;
  std::vector<RecordingParts> below;
  for (const fs::path& path : inside) {
    if (fs::is_directory(path)) {
      std::vector<RecordingParts> some = recordings_below(path, seen);
      std::move(some.begin(), some.end(), std::back_inserter(below));
    } else if (is_recording(path)) {
      known.push_back(path);
    }
  }
  std::vector<RecordingParts> found = recordings_of(known);
  if (has_messages && found.size() == 1 && below.empty()) return {{folder}};
  std::move(below.begin(), below.end(), std::back_inserter(found));
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

std::vector<RecordingParts> recordings_of(const std::vector<fs::path>& inputs) {
  std::vector<RecordingParts> found;
  for (RecordingParts& parts : ros::recordings_of(inputs)) {
    const bool is_next_scan =
        !found.empty() && is_scan_file(found.back().back()) && is_scan_file(parts.front());
    if (is_next_scan) {
      found.back().push_back(parts.front());
    } else {
      found.push_back(std::move(parts));
    }
  }
  return found;
}

std::vector<RecordingParts> recordings_in(const fs::path& folder) {
  std::set<fs::path> seen;
  return recordings_below(folder, seen);
}

}  // namespace marco
