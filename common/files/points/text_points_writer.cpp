#include "common/files/points/point_formats.hpp"
#include "common/files/points/text_writer.hpp"

namespace marco::files {
namespace {

constexpr int kMetreDecimals = 5;

struct LineParts {
  bool has_intensity = false, has_color = false;
};

Eigen::Vector3d absolute_m(const PointCloud& cloud, std::size_t i) {
  return cloud.points_m[i].cast<double>() + cloud.origin_m;
}

LineParts parts_of(const PointCloud& cloud) {
  return {!cloud.intensities.empty(), !cloud.colors_rgb.empty()};
}

void write_numbers(TextWriter& text, const Eigen::Vector3d& numbers, int decimals, char after) {
  text.fixed(numbers.x(), decimals, ' ');
  text.fixed(numbers.y(), decimals, ' ');
  text.fixed(numbers.z(), decimals, after);
}

void write_line(TextWriter& text,
                const PointCloud& cloud,
                std::size_t i,
                const Eigen::Vector3d& point,
                int decimals) {
  const auto [has_intensity, has_color] = parts_of(cloud);
  write_numbers(text, point, decimals, has_intensity || has_color ? ' ' : '\n');
  if (has_intensity) text.number(cloud.intensities[i], has_color ? ' ' : '\n');
  if (!has_color) return;
  const auto& [red, green, blue] = cloud.colors_rgb[i];
  text.number(int{red}, ' ');
  text.number(int{green}, ' ');
  text.number(int{blue}, '\n');
}

void flush(OutputFile& file, TextWriter& text) {
  file.write(text.text());
  text.clear();
}

void write_finite_points(OutputFile& file, const PointCloud& cloud) {
  TextWriter text;
  for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
    if (!cloud.points_m[i].allFinite()) continue;
    write_line(text, cloud, i, absolute_m(cloud, i), kMetreDecimals);
    flush(file, text);
  }
}

Pose3 pose_or_identity(const PointCloud& cloud) {
  return cloud.world_from_scanner.value_or(Pose3::Identity());
}

void write_ptx_header(TextWriter& text, const PointCloud& cloud) {
  text.number(cloud.rows, '\n');
  text.number(cloud.rows == 0 ? 0 : cloud.points_m.size() / cloud.rows, '\n');
  const Pose3 pose = pose_or_identity(cloud);
  const auto write_vector = [&](const Eigen::Vector3d& v, bool ends_line) {
    text.number(v.x(), ' ');
    text.number(v.y(), ' ');
    text.number(v.z(), ends_line ? '\n' : ' ');
  };
  write_vector(pose.translation(), true);
  for (int axis = 0; axis < 3; ++axis) write_vector(pose.linear().col(axis), true);
  for (int column = 0; column < 4; ++column) {  // of row vectors
    write_vector(pose.matrix().block<3, 1>(0, column), false);
    text.number(column < 3 ? 0 : 1, '\n');
  }
}

}  // namespace

void write_xyz(OutputFile& file, const PointCloud& cloud) { write_finite_points(file, cloud); }

void write_pts(OutputFile& file, const PointCloud& cloud) {
  std::size_t count = 0;
  for (const Eigen::Vector3f& point : cloud.points_m) count += point.allFinite() ? 1U : 0U;
  file.write(std::to_string(count) + "\n");
  write_finite_points(file, cloud);
}

void write_uos(OutputFile& file, const PointCloud& cloud) {
  constexpr int kCentimetreDecimals = 3;
  TextWriter text;
  for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
    if (!cloud.points_m[i].allFinite()) continue;
    const Eigen::Vector3d m = absolute_m(cloud, i);
    write_line(text, cloud, i, 100.0 * Eigen::Vector3d(-m.y(), m.z(), m.x()), kCentimetreDecimals);
    flush(file, text);
  }
}

// Leica's programs want an intensity in each line: 0.5 stands for none.
void write_ptx(OutputFile& file, const PointCloud& cloud) {
  TextWriter text;
  write_ptx_header(text, cloud);
  const auto [has_intensity, has_color] = parts_of(cloud);
  for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
    const bool is_return = cloud.points_m[i].allFinite();
    const Eigen::Vector3d point_m =
        is_return ? absolute_m(cloud, i) : Eigen::Vector3d(Eigen::Vector3d::Zero());
    write_numbers(text, point_m, kMetreDecimals, ' ');
    text.number(has_intensity ? cloud.intensities[i] : 0.5F, has_color ? ' ' : '\n');
    for (std::size_t c = 0; has_color && c < 3; ++c) {
      text.number(int{cloud.colors_rgb[i][c]}, c < 2 ? ' ' : '\n');
    }
    flush(file, text);
  }
  flush(file, text);
}

}  // namespace marco::files
