#include "recordings/recording.hpp"

#include <array>
#include <cstring>
#include <fstream>
#include <string>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"
#include "recordings/carmen.hpp"
#include "recordings/lcm_log_reader.hpp"
#include "recordings/odometry_laser_text.hpp"
#include "recordings/thesis_files.hpp"
#include "recordings/tilted_scans.hpp"

namespace marco {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKnown =
    "known inputs: LCM logs, CARMEN logs, text logs of 'Odometry' and 'Laser' lines, folders of 3D "
    "scans "
    "(*_tilt_ranges_mm.csv, *.3d, scan_polar.csv), the theses' scan files";

std::string head_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(1 << 16, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head;
}

bool has_line_starting_with(const std::string& text, const char* keyword) {
  const std::string at_start = keyword, inside = std::string("\n") + keyword;
  return text.rfind(at_start, 0) == 0 || text.find(inside) != std::string::npos;
}

std::string looks_like(const std::string& head) {
  const auto starts = [&head](std::string_view magic) { return head.rfind(magic, 0) == 0; };
  if (starts("\x89PNG")) return "a PNG picture";
  if (starts("\xFF\xD8\xFF")) return "a JPEG picture";
  if (starts("GIF8") || starts("BM")) return "a picture";
  if (starts("\x1F\x8B")) return "a gzip file: unpack it first";
  if (starts("PK\x03\x04")) return "a zip file: unpack it first";
  if (starts("#ROSBAG")) return "a ROS bag: export its scans to a CARMEN or LCM log first";
  if (starts("ply")) return "a model: `./marco render` draws it";
  if (head.find('\0') != std::string::npos) return "binary data of no known kind";
  return "text of no known kind";
}

}  // namespace

std::unique_ptr<files::SampleReader> open_recording(const fs::path& path,
                                                    const ForeignTable& table) {
  const std::string name = path.string();
  files::require_readable(path);
  if (fs::is_directory(path)) return files::open_tilted_scans({path});
  const std::string head = head_of(path);
  require(!head.empty(), name + ": is empty; " + kKnown);
  // A damaged log may have lost its first sync word: any in the first block will do.
  if (head.find("\xED\xA1\xDA\x01") != std::string::npos) return open_lcm_log(path, table);
  for (const char* keyword :
       {"FLASER ", "RLASER ", "ROBOTLASER1 ", "ROBOTLASER2 ", "ODOM ", "PARAM "}) {
    if (has_line_starting_with(head, keyword)) return files::open_carmen(path);
  }
  if (has_line_starting_with(head, "Laser ") || has_line_starting_with(head, "Odometry ")) {
    return files::open_odometry_laser_text(path);
  }
  // Not every reader behind this line would notice soon that it reads no text.
  require(head.find('\0') == std::string::npos,
          name + ": looks like " + looks_like(head) + "; " + kKnown);
  if (files::is_tilted_scan(path)) return files::open_tilted_scans({path});
  if (files::is_thesis_file(path)) return files::open_thesis_file(path);
  throw std::invalid_argument(name + ": looks like " + looks_like(head) + "; " + kKnown);
}

std::string why_no_log(const fs::path& path) {
  const std::string name = path.string();
  const std::string nothing = name + ": holds no whole LCM event";
  const std::string head = head_of(path);
  if (head.empty()) return nothing + "; it is empty";
  try {
    const std::string format = open_recording(path)->report().format;
    if (format == "LCM log") return nothing;
    return name + ": is no LCM log but a " + format + "; `marco log import " + name +
           " OUT.lcm` makes an LCM log of it";
  } catch (const std::exception&) {  // nor any other recording
    return nothing + "; it looks like " + looks_like(head);
  }
}

}  // namespace marco
