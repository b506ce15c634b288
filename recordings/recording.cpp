#include "recordings/recording.hpp"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"
#include "lcm_tools/process/config.hpp"
#include "recordings/lcm_log_reader.hpp"
#include "recordings/recording_folder.hpp"
#include "recordings/ros/open_messages.hpp"
#include "recordings/ros/ros_reader.hpp"
#include "recordings/text_formats.hpp"
#include "recordings/tilted_scans.hpp"

namespace marco {
namespace {

namespace fs = std::filesystem;

struct Input {
  const RecordingParts& parts;
  std::string head;  // the first bytes of the first; "" of a folder
  const ForeignTable& foreign;

  const fs::path& path() const { return parts.front(); }
  bool is_text() const { return head.find('\0') == std::string::npos; }
  bool has_line_with(std::initializer_list<std::string> keywords) const {
    return std::any_of(keywords.begin(), keywords.end(), [this](const std::string& keyword) {
      return head.rfind(keyword + " ", 0) == 0 ||
             head.find("\n" + keyword + " ") != std::string::npos;
    });
  }
};

struct Format {
  const char* name;  // as known_formats() lists it
  bool (*recognises)(const Input&);
  std::unique_ptr<files::SampleReader> (*open)(const Input&);
};

// The first that recognises an input reads it.
constexpr std::array<Format, 7> kFormats{{
    {"ROS recordings (.bag, .mcap, .db3 and folders of them)",
     [](const Input& input) { return ros::is_message_recording(input.path()); },
     [](const Input& input) {
       return ros::open_ros(ros::open_messages(input.parts), input.foreign.ros);
     }},
    {"folders of 3D scans (*_tilt_ranges_mm.csv, *.3d, scan_polar.csv)",
     [](const Input& input) { return fs::is_directory(input.path()); },
     [](const Input& input) { return files::open_tilted_scans(input.parts); }},
    // A damaged log may have lost its first sync word: any in the first block will do.
    {"LCM logs",
     [](const Input& input) { return input.head.find("\xED\xA1\xDA\x01") != std::string::npos; },
     [](const Input& input) { return open_lcm_log(input.path(), input.foreign); }},
    {"CARMEN logs",
     [](const Input& input) {
       return input.has_line_with(
           {"FLASER", "RLASER", "ROBOTLASER1", "ROBOTLASER2", "ODOM", "PARAM"});
     },
     [](const Input& input) { return files::open_carmen(input.path()); }},
    {"text logs of 'Odometry' and 'Laser' lines",
     [](const Input& input) {
       return input.has_line_with({"Laser", "Odometry"});
     },
     [](const Input& input) { return files::open_odometry_laser_text(input.path()); }},
    {"files of 3D scans",
     [](const Input& input) { return input.is_text() && files::is_tilted_scan(input.path()); },
     [](const Input& input) { return files::open_tilted_scans(input.parts); }},
    {"the theses' scan files",
     [](const Input& input) { return input.is_text() && files::is_thesis_file(input.path()); },
     [](const Input& input) { return files::open_thesis_file(input.path()); }},
}};

std::string known_formats() {
  std::string names;
  for (const Format& format : kFormats)
    names += (names.empty() ? "" : ", ") + std::string(format.name);
  return "known inputs: " + names;
}

std::string head_of(const fs::path& path) { return files::first_bytes(path, 1 << 16); }

std::string looks_like(const std::string& head) {
  constexpr std::array<std::pair<std::string_view, const char*>, 7> kMagics{
      {{"\x89PNG", "a PNG picture"},
       {"\xFF\xD8\xFF", "a JPEG picture"},
       {"GIF8", "a picture"},
       {"BM", "a picture"},
       {"\x1F\x8B", "a gzip file: unpack it first"},
       {"PK\x03\x04", "a zip file: unpack it first"},
       {"ply", "a model: `./marco render` draws it"}}};
  for (const auto& [magic, kind] : kMagics) {
    if (head.rfind(magic, 0) == 0) return kind;
  }
  const bool binary = head.find('\0') != std::string::npos;
  return binary ? "binary data in an unknown format" : "text in an unknown format";
}

}  // namespace

std::unique_ptr<files::SampleReader> open_recording(const RecordingParts& parts,
                                                    const ForeignTable& table) {
  const fs::path& path = parts.front();
  for (const fs::path& part : parts) files::require_readable(part);
  const bool is_folder = fs::is_directory(path);
  if (is_folder) {
    const std::vector<RecordingParts> inside = recordings_in(path);
    require_one(path, inside);
    if (!inside.empty() && inside.front() != parts) return open_recording(inside.front(), table);
  }
  // What somebody wrote about this recording counts before what holds for all.
  const fs::path beside = path.string() + ".marco.toml";
  const ForeignTable own =
      fs::is_regular_file(beside) ? process::load_options<ForeignTable>(beside.string()) : table;
  const Input input{parts, is_folder ? "" : head_of(path), own};
  require(is_folder || !input.head.empty(), path.string() + ": is empty; " + known_formats());
  for (const Format& format : kFormats) {
    if (format.recognises(input)) return format.open(input);
  }
  throw std::invalid_argument(path.string() + ": looks like " + looks_like(input.head) + "; " +
                              known_formats());
}

std::unique_ptr<files::SampleReader> open_recording(const fs::path& path,
                                                    const ForeignTable& table) {
  return open_recording(RecordingParts{path}, table);
}

bool is_recording(const fs::path& path) {
  if (fs::is_directory(path)) return !recordings_in(path).empty();
  const std::string head = head_of(path);
  const ForeignTable none;
  const RecordingParts parts{path};
  const Input input{parts, head, none};
  return !head.empty() && std::any_of(kFormats.begin(), kFormats.end(), [&](const Format& format) {
    return format.recognises(input);
  });
}

std::string why_no_log(const fs::path& path) {
  const std::string name = path.string();
  std::string nothing = name + ": has no complete LCM event";
  const std::string head = head_of(path);
  if (head.empty()) return nothing + "; it is empty";
  try {
    const std::string format = open_recording(path)->report().format;
    if (format == "LCM log") return nothing;
    return name + ": is not an LCM log but a " + format + "; `marco log import " + name +
           " OUT.lcm` converts it";
  } catch (const std::exception&) {  // no other recording either
    return nothing + "; it looks like " + looks_like(head);
  }
}

}  // namespace marco
