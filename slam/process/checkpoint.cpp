#include "slam/process/checkpoint.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

#include "common/byte_archive.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco {

template <class Archive>
void archive(Archive& bytes, StampedPose2& pose) {
  archive(bytes, pose.utime);
  archive(bytes, pose.world_from_robot);
}

template <class Archive>
void archive(Archive& bytes, Pose3& pose) {
  bytes.raw(pose.matrix().data(), 16 * sizeof(double));
}

template <class Archive>
void archive(Archive& bytes, PanTiltState& state) {
  archive(bytes, state.utime);
  archive(bytes, state.pan_rad);
  archive(bytes, state.tilt_rad);
}

template <class Archive>
void archive(Archive& bytes, SensorInfo& info) {
  archive(bytes, info.utime);
  archive(bytes, info.channel);
  auto mount = static_cast<uint8_t>(info.mount);
  archive(bytes, mount);
  info.mount = mount == 0 ? SensorInfo::Mount::robot : SensorInfo::Mount::pantilt;
  archive(bytes, info.parent_from_sensor);
  archive(bytes, info.tilt_axis_m);
  archive(bytes, info.scan_duration_s);
  archive(bytes, info.range_min_m);
  archive(bytes, info.range_max_m);
  archive(bytes, info.range_sigma_m);
  archive(bytes, info.focal_length_px);
}

// Ranges may hold NaN and infinity: as they are.
template <class Archive>
void archive_floats(Archive& bytes, std::vector<float>& values) {
  values.resize(bytes.length(values.size(), sizeof(float)));
  bytes.raw(values.data(), values.size() * sizeof(float));
}

template <class Archive>
void archive(Archive& bytes, LaserScan& scan) {
  archive(bytes, scan.utime);
  archive(bytes, scan.channel);
  archive_floats(bytes, scan.ranges_m);
  archive(bytes, scan.first_bearing_rad);
  archive(bytes, scan.bearing_step_rad);
  archive_floats(bytes, scan.bearings_rad);
  archive_floats(bytes, scan.time_offsets_s);
}

template <class Archive>
void archive(Archive& bytes, PoseBuffer& buffer) {
  std::vector<StampedPose2> samples;
  if constexpr (!Archive::kReads) samples = buffer.samples();
  archive_list(bytes, samples, sizeof(StampedPose2));
  if constexpr (Archive::kReads) {
    buffer.clear();
    for (const StampedPose2& sample : samples) buffer.add(sample.utime, sample.world_from_robot);
  }
}

template <class Archive, class Value>
void archive(Archive& bytes, std::map<std::string, Value>& values) {
  std::vector<std::pair<std::string, Value>> list(values.begin(), values.end());
  list.resize(bytes.length(list.size(), sizeof(uint64_t)));
  for (auto& [name, value] : list) {
    archive(bytes, name);
    archive(bytes, value);
  }
  if constexpr (Archive::kReads) {
    values = {list.begin(), list.end()};
  }
}

}  // namespace marco

namespace marco::slam {
namespace {

constexpr std::string_view kName = "MARCOCHK";
// From the oldest on; a layout of SlamState for each.
constexpr uint32_t kOldest = 15, kVersion = 16, kOldestLayout = 12;

std::filesystem::path before(const std::filesystem::path& path) {
  return path.string() + ".before";
}

std::filesystem::path ended(const std::filesystem::path& path) { return path.string() + ".ended"; }

}  // namespace

std::string encode_adapter_state(const AdapterState& state) {
  AdapterState copy = state;
  ByteWriter writer;
  archive(writer, copy);
  return seal(kName, kVersion, writer.take());
}

AdapterState decode_adapter_state(std::string_view bytes) {
  const Unsealed file = unseal(kName, kOldest, kVersion, bytes);
  ByteReader reader(file.payload, kOldestLayout + file.version - kOldest);
  AdapterState state;
  archive(reader, state);
  require(reader.left() == 0, "has bytes left over");
  check(state.map);
  return state;
}

void save_adapter_state(const std::filesystem::path& path, const AdapterState& state) {
  const std::string bytes = encode_adapter_state(state);
  // The one before gets a second name: there is a whole one under the first at any moment.
  std::error_code none;
  std::filesystem::remove(ended(path), none);
  std::filesystem::remove(before(path), none);
  std::filesystem::create_hard_link(path, before(path), none);
  if (none) std::filesystem::copy_file(path, before(path), none);
  files::write_whole_file(path, bytes);
}

std::optional<AdapterState> load_adapter_state(
    const std::filesystem::path& path, const std::function<void(const std::string&)>& warn) {
  for (const std::filesystem::path& candidate : {path, before(path)}) {
    if (!std::filesystem::exists(candidate)) continue;
    try {
      return decode_adapter_state(files::read_whole_file(candidate));
    } catch (const std::invalid_argument& wrong) {
      if (warn) warn("checkpoint " + candidate.string() + " " + wrong.what() + ": not used");
    }
  }
  return std::nullopt;
}

std::string time_of(const std::filesystem::path& checkpoint) {
  struct stat status = {};
  stat(checkpoint.c_str(), &status);
  std::tm local = {};
  localtime_r(&status.st_mtime, &local);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d_%H-%M-%S", &local);
  return text;
}

void put_checkpoint_aside(const std::filesystem::path& path,
                          const std::function<void(const std::string&)>& warn) {
  for (const std::filesystem::path& old : {path, before(path)}) {
    if (!std::filesystem::exists(old)) continue;
    const std::string aside = old.string() + "." + time_of(old);
    std::filesystem::rename(old, aside);
    if (warn) warn("it was moved aside: " + aside);
  }
}

void mark_ended(const std::filesystem::path& path) { files::write_whole_file(ended(path), ""); }

CheckpointLock::CheckpointLock(const std::filesystem::path& path)
    : lock_(open((path.string() + ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (lock_ >= 0 && flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(lock_);
    throw std::runtime_error("another process is using the checkpoint " + path.string());
  }
}

CheckpointLock::~CheckpointLock() {
  if (lock_ >= 0) close(lock_);
}

}  // namespace marco::slam
