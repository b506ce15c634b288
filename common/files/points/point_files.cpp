#include "common/files/points/point_files.hpp"

#include <array>

#include "common/files/points/point_formats.hpp"
#include "common/files/points/scan_pose.hpp"
#include "common/files/points/text_columns.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {
namespace {

// Three and more numbers a line, after one line of names: XYZ. One number before: PTS; two lines of
// one: PTX.
std::optional<PointFormat> text_format_of(std::string_view head) {
  const std::string nobody;
  TextRows rows(head, nobody);
  // A row of ranges has more numbers than any point.
  std::array<double, kMaxTextColumns + 1> numbers{};
  const auto count_next = [&] { return rows.next() ? rows.numbers(numbers) : 0; };
  const auto is_point = [](std::size_t count) { return count >= 3 && count <= kMaxTextColumns; };
  const bool has_line = rows.next();
  const std::size_t first = has_line ? rows.numbers(numbers) : 0;
  if (!has_line || first == 2 || first > kMaxTextColumns) return std::nullopt;
  if (first >= 3) return PointFormat::xyz;
  const std::size_t second = count_next();
  if (first == 1 && second == 1) {
    return count_next() >= 3 ? std::optional(PointFormat::ptx) : std::nullopt;
  }
  if (!is_point(second)) return std::nullopt;
  return first == 1 ? PointFormat::pts : PointFormat::xyz;
}

bool is_uos(std::string_view head) {
  const std::string nobody;
  TextRows rows(head, nobody);
  std::array<double, 3> numbers{};
  if (!rows.next()) return false;
  const std::size_t first = rows.numbers(numbers);
  return first == 3 || (first == 2 && rows.next() && rows.numbers(numbers) == 3);
}

bool is_pcd(std::string_view head) {
  while (head.starts_with('#') || head.starts_with('\n') || head.starts_with('\r')) {
    if (head.starts_with("# .PCD")) return true;
    const std::size_t end = head.find('\n');
    if (end == std::string_view::npos) return false;
    head.remove_prefix(end + 1);
  }
  for (const char* key : {"VERSION ", "FIELDS ", "COLUMNS "}) {
    if (head.starts_with(key)) return true;
  }
  return false;
}

std::optional<PointFormat> format_of(std::string_view head, const std::filesystem::path& path) {
  if (head.starts_with("ply\n") || head.starts_with("ply\r\n")) return PointFormat::ply;
  if (is_pcd(head)) return PointFormat::pcd;
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == ".3d") return is_uos(head) ? std::optional(PointFormat::uos) : std::nullopt;
  for (const char* text : {".xyz", ".txt", ".asc", ".csv", ".pts", ".ptx"}) {
    if (ending == text) return text_format_of(head);
  }
  return std::nullopt;
}

PointCloud read_as(PointFormat format, const std::string& content, const std::string& name) {
  switch (format) {
    case PointFormat::pcd:
      return read_pcd(content, name);
    case PointFormat::ply:
      return read_ply_points(content, name);
    case PointFormat::xyz:
      return read_xyz(content, name);
    case PointFormat::pts:
      return read_pts(content, name);
    case PointFormat::ptx:
      return read_ptx(content, name);
    case PointFormat::uos:
      return read_uos(content, name);
  }
  throw std::invalid_argument("read_points: no such format");
}

void write_as(PointFormat format, OutputFile& file, const PointCloud& cloud) {
  switch (format) {
    case PointFormat::pcd:
      return write_pcd(file, cloud);
    case PointFormat::ply:
      return write_ply_points(file, cloud);
    case PointFormat::xyz:
      return write_xyz(file, cloud);
    case PointFormat::pts:
      return write_pts(file, cloud);
    case PointFormat::ptx:
      return write_ptx(file, cloud);
    case PointFormat::uos:
      return write_uos(file, cloud);
  }
}

void require_whole(PointFormat format, const PointCloud& cloud) {
  const std::size_t points = cloud.points_m.size();
  require((cloud.intensities.empty() || cloud.intensities.size() == points) &&
              (cloud.colors_rgb.empty() || cloud.colors_rgb.size() == points),
          "write_points: expected one intensity and colour per point, or none");
  require(cloud.rows == 0 || points % cloud.rows == 0, "write_points: " + std::to_string(points) +
                                                           " points are not " +
                                                           std::to_string(cloud.rows) + " rows");
  require(format != PointFormat::ptx || cloud.rows > 0,
          "write_points: a PTX file needs rows of points, but these are unorganized");
}

}  // namespace

std::optional<PointFormat> point_format_of(const std::filesystem::path& path) {
  const std::string head = first_bytes(path, 1 << 16);
  return head.empty() ? std::nullopt : format_of(head, path);
}

PointCloud read_points(const std::filesystem::path& path) {
  const std::string content = read_whole_file(path);
  const auto format = format_of(content, path);
  require(format.has_value(), path.string() + ": not a point file (PCD, PLY, XYZ, PTS, PTX, uos)");
  PointCloud cloud = read_as(*format, content, path.string());
  if (!cloud.world_from_scanner) cloud.world_from_scanner = read_scan_pose(pose_path_of(path));
  return cloud;
}

void write_points(const std::filesystem::path& path, PointFormat format, const PointCloud& cloud) {
  require_whole(format, cloud);
  OutputFile file(path);
  write_as(format, file, cloud);
  file.finish();
  const bool has_pose_inside = format == PointFormat::pcd || format == PointFormat::ptx;
  if (cloud.world_from_scanner && !has_pose_inside) {
    write_scan_pose(pose_path_of(path), *cloud.world_from_scanner);
  }
}

}  // namespace marco::files
