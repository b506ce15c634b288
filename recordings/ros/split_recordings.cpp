#include "recordings/ros/split_recordings.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "lcm_tools/files/readable.hpp"
#include "recordings/ros/open_messages.hpp"

namespace marco {

void require_one(const std::filesystem::path& folder,
                 const std::vector<RecordingParts>& recordings) {
  if (recordings.size() <= 1) return;
  constexpr std::size_t kNamed = 3;
  std::string names;
  for (std::size_t i = 0; i < std::min(kNamed, recordings.size()); ++i) {
    names += recordings[i].front().lexically_relative(folder).string() + ", ";
  }
  names += recordings.size() > kNamed ? "..." : "";
  if (names.ends_with(", ")) names.resize(names.size() - 2);
  throw std::invalid_argument(folder.string() + ": holds " + std::to_string(recordings.size()) +
                              " different recordings (" + names +
                              "): name one of them; `./marco "
                              "map --many " +
                              folder.string() + "` maps each");
}

namespace ros {
namespace {

namespace fs = std::filesystem;

// A file whose name has a number at its end: files of one series differ by that alone.
struct NumberedFile {
  std::string series;                         // its path without the number
  std::pair<std::size_t, std::string> order;  // of the number: "2" before "10"
  fs::path path;

  bool operator<(const NumberedFile& other) const {
    return std::tie(order, path) < std::tie(other.order, other.path);
  }
};

// The recorders' dates (2020-01-31-12-00-00, 2020_01_31-12_00_00) change from part to part. Parts
// that were not closed, or were packed, have an ending more.
std::optional<NumberedFile> numbered_file(const fs::path& path) {
  static const std::regex kDate("[0-9]{4}([-_][0-9]{2}){5}");
  static const std::regex kAdded("(\\.zst|\\.zstd|\\.active)+$");
  static const std::regex kNumbered("(.*?)0*([0-9]+)((\\.[A-Za-z][A-Za-z0-9]*)*)");
  std::string name = std::regex_replace(path.filename().string(), kDate, "");
  name = std::regex_replace(name, kAdded, "");
  std::smatch found;
  if (!std::regex_match(name, found, kNumbered)) return std::nullopt;
  const std::string number = found[2];
  // No name holds a slash: stem and ending do not run together.
  const std::string series = (path.parent_path() / found[1].str()).string() + "/" + found[3].str();
  return NumberedFile{series, {number.size(), number}, path};
}

struct Contents {
  std::map<std::string, std::string> types;  // by topic
  TimeSpan span;
};

std::optional<Contents> contents_of(const fs::path& path) {
  try {
    const auto source = open_messages(path);
    const auto span = source->span();
    if (!span || !source->next()) return std::nullopt;  // without an index it is read for topics
    Contents contents{{}, *span};
    for (const Topic* topic : source->topics()) contents.types[topic->name] = topic->type;
    return contents;
  } catch (const std::exception&) {  // reported when it is mapped
    return std::nullopt;
  }
}

// A topic of few messages may be missing in a part.
bool have_same_topics(const Contents& a, const Contents& b) {
  std::size_t shared = 0;
  for (const auto& [name, type] : a.types) {
    const auto other = b.types.find(name);
    if (other == b.types.end()) continue;
    if (other->second != type) return false;
    ++shared;
  }
  return shared > 0 && 2 * shared >= std::min(a.types.size(), b.types.size());
}

// A recorder's threads may hand over late what came before the split, and rare messages leave a
// pause. Starting another recording manually takes longer.
bool follows(const Contents& before, const Contents& after) {
  constexpr int64_t kMostPauseNs = 5'000'000'000, kMostOverlapNs = 1'000'000'000;
  const int64_t shorter_ns = std::min(before.span.last_ns - before.span.first_ns,
                                      after.span.last_ns - after.span.first_ns);
  const int64_t pause_ns = after.span.first_ns - before.span.last_ns;
  return pause_ns >= -std::min(kMostOverlapNs, shorter_ns / 10) && pause_ns <= kMostPauseNs &&
         have_same_topics(before, after);
}

void add_series(std::vector<NumberedFile> series, std::vector<RecordingParts>& found) {
  std::sort(series.begin(), series.end());
  std::optional<Contents> before;
  for (const NumberedFile& file : series) {
    std::optional<Contents> now = series.size() > 1 ? contents_of(file.path) : std::nullopt;
    if (!before || !now || !follows(*before, *now)) found.emplace_back();
    found.back().push_back(file.path);
    before = std::move(now);
  }
}

std::vector<std::string> names_in_metadata(const fs::path& folder) {
  static const std::regex kItem("\\s*-\\s+[\"']?([^\"']+?)[\"']?\\s*");
  std::vector<std::string> names;
  std::istringstream file(files::first_bytes(folder / "metadata.yaml", 16 << 20));
  bool is_in_list = false;
  for (std::string line; std::getline(file, line);) {
    std::smatch item;
    if (line.find("relative_file_paths:") != std::string::npos) {
      is_in_list = true;
    } else if (is_in_list && std::regex_match(line, item, kItem)) {
      names.push_back(item[1]);
    } else if (is_in_list) {
      break;
    }
  }
  return names;
}

}  // namespace

RecordingParts parts_by_metadata(const fs::path& folder) {
  RecordingParts parts;
  for (const std::string& name : names_in_metadata(folder)) {
    // Early versions of rosbag2 wrote paths from where the recorder stood.
    const fs::path part = folder / fs::path(name).filename();
    const bool is_packed = part.extension() == ".zst" || part.extension() == ".zstd";
    const fs::path unpacked = is_packed ? fs::path(part).replace_extension() : part;
    for (const fs::path& path :
         {part, unpacked, fs::path(part) += ".zstd", fs::path(part) += ".zst"}) {
      if (!is_message_file(path)) continue;
      parts.push_back(path);
      break;
    }
  }
  return parts;
}

std::vector<RecordingParts> recordings_of(const std::vector<fs::path>& files) {
  std::map<fs::path, std::size_t> mentioned;  // where first
  for (std::size_t i = 0; i < files.size(); ++i) mentioned.emplace(files[i], i);
  std::vector<RecordingParts> found;
  std::set<fs::path> joined;
  std::map<fs::path, RecordingParts> by_metadata;  // by folder
  std::map<std::string, std::vector<NumberedFile>> series;
  for (const auto& [path, index] : mentioned) {
    const fs::path folder = path.parent_path();
    if (is_message_file(path) && !by_metadata.contains(folder)) {
      RecordingParts& parts = by_metadata[folder];
      parts = parts_by_metadata(folder);
      std::erase_if(parts, [&](const fs::path& part) { return !mentioned.contains(part); });
      joined.insert(parts.begin(), parts.end());
      if (!parts.empty()) found.push_back(parts);
    }
    if (joined.contains(path)) continue;
    const auto numbered = is_message_file(path) ? numbered_file(path) : std::nullopt;
    if (numbered) {
      series[numbered->series].push_back(*numbered);
    } else {
      found.push_back({path});
    }
  }
  for (const auto& [name, members] : series) add_series(members, found);
  const auto first_mention = [&](const RecordingParts& parts) {
    std::size_t first = files.size();
    for (const fs::path& part : parts) first = std::min(first, mentioned.at(part));
    return first;
  };
  std::sort(found.begin(), found.end(),
            [&](const auto& a, const auto& b) { return first_mention(a) < first_mention(b); });
  return found;
}

std::vector<RecordingParts> recordings_in(const fs::path& folder) {
  if (RecordingParts parts = parts_by_metadata(folder); !parts.empty()) return {parts};
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const bool is_hidden = entry.path().filename().string().starts_with('.');
    if (!is_hidden && is_message_file(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return recordings_of(files);
}

}  // namespace ros
}  // namespace marco
