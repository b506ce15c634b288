#include "common/files/points/point_formats.hpp"
#include "common/files/points/scan_pose.hpp"
#include "common/files/points/text_columns.hpp"

namespace marco::files {
namespace {

constexpr double kNoIntensity = 0.5;  // what Leica writes where there is none

struct PtxHeader {
  std::size_t columns = 0, rows = 0;
  std::optional<Pose3> world_from_scanner;
};

void read_ptx_line(TextRows& rows, std::span<double> numbers) {
  if (!rows.next()) rows.fail("ends inside its header");
  if (rows.numbers(numbers) < numbers.size()) {
    rows.fail("expected " + std::to_string(numbers.size()) + " numbers of a PTX header");
  }
}

std::size_t read_ptx_count(TextRows& rows) {
  double count = 0.0;
  read_ptx_line(rows, {&count, 1});
  if (!(count >= 0.0 && count <= static_cast<double>(rows.bytes_left()) &&
        count == std::floor(count))) {
    rows.fail("declares more points than the file contains");
  }
  return static_cast<std::size_t>(count);
}

PtxHeader read_ptx_header(TextRows& rows, const std::string& name) {
  constexpr std::size_t kShortestLine = 6;  // three digits, two blanks, an end
  PtxHeader header;
  header.columns = read_ptx_count(rows);
  header.rows = read_ptx_count(rows);
  // Position and axes of the scanner: the matrix says them, too.
  std::array<double, 3> passed{};
  for (int line = 0; line < 4; ++line) read_ptx_line(rows, passed);
  // Of row vectors: the last row is the position.
  Eigen::Matrix4d matrix;
  for (int line = 0; line < 4; ++line) {
    std::array<double, 4> numbers{};
    read_ptx_line(rows, numbers);
    matrix.col(line) = Eigen::Map<const Eigen::Vector4d>(numbers.data());
  }
  if (!matrix.isIdentity(0.0)) header.world_from_scanner = rigid_pose(matrix, name);
  const std::size_t most = (rows.bytes_left() + 1) / kShortestLine;
  if (header.columns > 0 && header.rows > most / header.columns) {
    rows.fail("declares more points than the file contains");
  }
  return header;
}

}  // namespace

PointCloud read_ptx(const std::string& content, const std::string& name) {
  return collect_points([&](PointCollector& points) {
    TextRows rows(content, name);
    const PtxHeader header = read_ptx_header(rows, name);
    points.cloud.world_from_scanner = header.world_from_scanner;
    points.cloud.rows = header.columns;  // the points of a column lie together
    const TextColumns columns = find_text_columns(rows);
    points.reserve(header.columns * header.rows,
                   {columns.intensity.has_value(), columns.rgb.has_value()});
    bool has_intensity = false;
    for (std::size_t i = 0; i < header.columns * header.rows; ++i) {
      if (!rows.next()) rows.fail("ends before its last point");
      const TextNumbers numbers = columns.numbers(rows);
      Eigen::Vector3d point_m(numbers[0], numbers[1], numbers[2]);
      if (point_m.isZero(0.0)) point_m.setConstant(std::numeric_limits<double>::quiet_NaN());
      columns.add(numbers, point_m, points);
      has_intensity = has_intensity || (columns.intensity && numbers[3] != kNoIntensity);
    }
    if (!has_intensity) points.cloud.intensities.clear();
    if (rows.next()) rows.fail("a second scan begins: a file of one scan is expected");
  });
}

}  // namespace marco::files
