#include "slam/process/line_checkpoint.hpp"

#include <filesystem>
#include <stdexcept>
#include <type_traits>

#include "common/byte_archive.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::slam {

template <class Archive, class Visited>
void archive_visited(Archive& bytes, Visited& value_of) {
  auto visitor = [&bytes](const char* /*name*/, auto& value) {
    if constexpr (std::is_same_v<decltype(value), std::vector<float>&>) {
      archive_list(bytes, value, sizeof(float));
    } else {
      archive(bytes, value);
    }
  };
  value_of.visit(visitor);
}

template <class Archive>
void archive(Archive& bytes, MapWall& wall) {
  archive_visited(bytes, wall);
}

template <class Archive>
void archive(Archive& bytes, MapCircle& circle) {
  archive_visited(bytes, circle);
}

template <class Archive>
void archive(Archive& bytes, CircleCandidate& candidate) {
  archive_visited(bytes, candidate);
}

// Columns of a size that was read before: used only when that many bytes are left.
template <class Archive, class Matrix>
void archive_sized(Archive& bytes, Matrix& matrix, Eigen::Index rows, Eigen::Index columns) {
  if constexpr (Archive::kReads) {
    require(bytes.left() / sizeof(double) >= static_cast<std::size_t>(rows * columns),
            "is truncated");
    matrix.resize(rows, columns);
  }
  bytes.raw(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
  require(matrix.allFinite(), "holds a number that is not finite");
}

template <class Archive>
void archive(Archive& bytes, WallFilter::Stored& filter) {
  archive(bytes, filter.next_id);
  archive_list(bytes, filter.walls, 50);  // fewest bytes of one
  archive(bytes, filter.circles.next_id);
  archive_list(bytes, filter.circles.circles, 70);      // fewest bytes of one
  archive_list(bytes, filter.circles.candidates, 100);  // likewise
  const std::size_t count = filter.walls.size() + filter.circles.circles.size();
  require(count <= 100000, "has too many walls");
  const auto size = static_cast<Eigen::Index>(3 + 4 * count);
  archive_sized(bytes, filter.mean, size, 1);
  archive_sized(bytes, filter.first_estimate, size, 1);
  archive_sized(bytes, filter.covariance, size, size);
}

// Beams that returned nothing hold no numbers.
template <class Archive>
void archive(Archive& bytes, Beam& beam) {
  archive(bytes, beam.returned);
  if (!beam.returned) return;
  archive(bytes, beam.hit_m);
  archive(bytes, beam.range_m);
}

template <class Archive>
void archive(Archive& bytes, ScanInRobot& scan) {
  archive(bytes, scan.sensor_m);
  archive(bytes, scan.first_bearing_rad);
  archive(bytes, scan.bearing_step_rad);
  archive(bytes, scan.range_sigma_m);
  archive(bytes, scan.bearing_sigma_rad);
  archive_list(bytes, scan.beams, 1);
}

template <class Archive>
void archive(Archive& bytes, LineMapper::Stored& mapper) {
  archive(bytes, mapper.lines.filter);
  archive(bytes, mapper.lines.step_from_robot);
  archive(bytes, mapper.lines.scans_since_step);
  archive(bytes, mapper.slam);
  archive_list(bytes, mapper.key_beams, 56);  // fewest bytes of each: without beams
  archive(bytes, mapper.slam_pose);
  archive(bytes, mapper.replays);
}

namespace {

constexpr std::string_view kLineCheckpointName = "MARCOLSL";
// From the oldest on; a layout of SlamState for each.
constexpr uint32_t kOldestLineCheckpoint = 7, kLineCheckpointVersion = 8, kOldestLayout = 12;

template <class Archive>
void archive_all(Archive& bytes, LineCheckpoint& checkpoint) {
  archive(bytes, checkpoint.utime);
  archive(bytes, checkpoint.map_revision);
  archive(bytes, checkpoint.mapper);
}

}  // namespace

std::vector<uint8_t> encode_checkpoint(const LineCheckpoint& checkpoint) {
  LineCheckpoint copy = checkpoint;
  ByteWriter writer;
  archive_all(writer, copy);
  const std::string sealed = seal(kLineCheckpointName, kLineCheckpointVersion, writer.take());
  return {sealed.begin(), sealed.end()};
}

LineCheckpoint decode_checkpoint(const std::vector<uint8_t>& bytes) {
  const std::string_view view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const Unsealed file =
      unseal(kLineCheckpointName, kOldestLineCheckpoint, kLineCheckpointVersion, view);
  ByteReader reader(file.payload, kOldestLayout + file.version - kOldestLineCheckpoint);
  LineCheckpoint checkpoint;
  archive_all(reader, checkpoint);
  require(reader.left() == 0, "has bytes left over");
  return checkpoint;
}

void save_checkpoint(const std::string& path, const LineCheckpoint& checkpoint) {
  const std::vector<uint8_t> bytes = encode_checkpoint(checkpoint);
  files::write_whole_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::optional<LineCheckpoint> load_checkpoint(const std::string& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const std::string text = files::read_whole_file(path);
  try {
    return decode_checkpoint({text.begin(), text.end()});
  } catch (const std::invalid_argument& wrong) {
    throw std::invalid_argument(path + ": " + wrong.what());
  }
}

}  // namespace marco::slam
