#include "slam/process/line_checkpoint.hpp"

#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>

#include "common/check.hpp"

namespace marco::slam {
namespace {

constexpr std::array<char, 8> kName = {'M', 'A', 'R', 'C', 'O', 'L', 'S', '1'};
constexpr std::size_t kHeadBytes = kName.size() + sizeof(uint64_t);
constexpr uint64_t kMaxWalls = 100000;

uint32_t crc32(const uint8_t* bytes, std::size_t count) {
  uint32_t crc = 0xFFFFFFFFU;
  for (std::size_t i = 0; i < count; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ (0xEDB88320U & (0U - (crc & 1U)));
  }
  return ~crc;
}

class Writer {
 public:
  template <class T>
  void put(const T& value) {
    const std::size_t at = bytes.size();
    bytes.resize(at + sizeof(T));
    std::memcpy(bytes.data() + at, &value, sizeof(T));
  }
  void put_values(const double* values, std::size_t count) {
    const std::size_t at = bytes.size();
    bytes.resize(at + count * sizeof(double));
    std::memcpy(bytes.data() + at, values, count * sizeof(double));
  }
  std::vector<uint8_t> bytes;
};

class Reader {
 public:
  Reader(const uint8_t* bytes, std::size_t count) : bytes_(bytes), left_(count) {}
  template <class T>
  T take() {
    T value;
    take_bytes(&value, sizeof(T));
    return value;
  }
  void take_values(double* values, std::size_t count) {
    take_bytes(values, count * sizeof(double));
  }
  std::size_t left() const { return left_; }

 private:
  void take_bytes(void* to, std::size_t count) {
    require(count <= left_, "checkpoint is cut short");
    std::memcpy(to, bytes_, count);
    bytes_ += count;
    left_ -= count;
  }
  const uint8_t* bytes_;
  std::size_t left_;
};

void put_wall(Writer& out, const MapWall& wall) {
  out.put(wall.id);
  out.put(wall.times_seen);
  out.put(static_cast<uint8_t>(wall.start_seen));
  out.put(static_cast<uint8_t>(wall.end_seen));
  out.put(wall.evidence.bin_m());
  out.put(wall.evidence.offset_m());
  out.put(wall.evidence.length_m());
  out.put(static_cast<uint64_t>(wall.evidence.log_odds().size()));
  for (const float log_odds : wall.evidence.log_odds()) out.put(log_odds);
}

MapWall take_wall(Reader& in) {
  MapWall wall;
  wall.id = in.take<int64_t>();
  wall.times_seen = in.take<int64_t>();
  wall.start_seen = in.take<uint8_t>() != 0;
  wall.end_seen = in.take<uint8_t>() != 0;
  const auto bin_m = in.take<double>();
  const auto offset_m = in.take<double>();
  const auto length_m = in.take<double>();
  const auto count = in.take<uint64_t>();
  require(count <= in.left() / sizeof(float), "checkpoint is cut short");
  std::vector<float> log_odds(count);
  for (float& value : log_odds) value = in.take<float>();
  wall.evidence = WallEvidence::restore(bin_m, offset_m, length_m, std::move(log_odds));
  return wall;
}

}  // namespace

std::vector<uint8_t> encode_checkpoint(const LineCheckpoint& checkpoint) {
  Writer out;
  for (const char letter : kName) out.put(letter);
  out.put(uint64_t{0});
  out.put(checkpoint.utime.us);
  out.put(static_cast<uint8_t>(checkpoint.odom_from_robot.has_value()));
  const Pose2 odom = checkpoint.odom_from_robot.value_or(Pose2{});
  out.put_values(odom.vector().data(), 3);
  out.put(checkpoint.map_revision);
  out.put(checkpoint.filter.next_id);
  out.put(static_cast<uint64_t>(checkpoint.filter.walls.size()));
  for (const MapWall& wall : checkpoint.filter.walls) put_wall(out, wall);
  const auto size = static_cast<std::size_t>(checkpoint.filter.mean.size());
  out.put_values(checkpoint.filter.mean.data(), size);
  out.put_values(checkpoint.filter.first_estimate.data(), size);
  out.put_values(checkpoint.filter.covariance.data(), size * size);
  const uint64_t payload = out.bytes.size() - kHeadBytes;
  std::memcpy(out.bytes.data() + kName.size(), &payload, sizeof(payload));
  out.put(crc32(out.bytes.data(), out.bytes.size()));
  return out.bytes;
}

LineCheckpoint decode_checkpoint(const std::vector<uint8_t>& bytes) {
  require(bytes.size() >= kHeadBytes + sizeof(uint32_t) &&
              std::memcmp(bytes.data(), kName.data(), kName.size()) == 0,
          "is no checkpoint of the line SLAM");
  uint64_t payload = 0;
  std::memcpy(&payload, bytes.data() + kName.size(), sizeof(payload));
  require(payload == bytes.size() - kHeadBytes - sizeof(uint32_t), "checkpoint is cut short");
  uint32_t crc = 0;
  std::memcpy(&crc, bytes.data() + bytes.size() - sizeof(crc), sizeof(crc));
  require(crc == crc32(bytes.data(), bytes.size() - sizeof(crc)), "checkpoint is damaged");

  Reader in(bytes.data() + kHeadBytes, payload);
  LineCheckpoint checkpoint;
  checkpoint.utime = Utime::from_us(in.take<int64_t>());
  const bool has_odometry = in.take<uint8_t>() != 0;
  Eigen::Vector3d odom;
  in.take_values(odom.data(), 3);
  if (has_odometry) checkpoint.odom_from_robot = Pose2::from_vector(odom);
  checkpoint.map_revision = in.take<int64_t>();
  checkpoint.filter.next_id = in.take<int64_t>();
  const auto count = in.take<uint64_t>();
  require(count <= kMaxWalls, "checkpoint has too many walls");
  for (uint64_t i = 0; i < count; ++i) checkpoint.filter.walls.push_back(take_wall(in));
  const auto size = static_cast<Eigen::Index>(3 + 4 * count);
  require(in.left() == sizeof(double) * static_cast<std::size_t>(size * (size + 2)),
          "checkpoint contradicts itself");
  checkpoint.filter.mean.resize(size);
  checkpoint.filter.first_estimate.resize(size);
  checkpoint.filter.covariance.resize(size, size);
  in.take_values(checkpoint.filter.mean.data(), static_cast<std::size_t>(size));
  in.take_values(checkpoint.filter.first_estimate.data(), static_cast<std::size_t>(size));
  in.take_values(checkpoint.filter.covariance.data(), static_cast<std::size_t>(size * size));
  return checkpoint;
}

void save_checkpoint(const std::string& path, const LineCheckpoint& checkpoint) {
  const std::vector<uint8_t> bytes = encode_checkpoint(checkpoint);
  const std::string beside = path + ".new";
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(beside.c_str(), "wb"),
                                                       &std::fclose);
  const bool written = file != nullptr &&
                       std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size() &&
                       std::fflush(file.get()) == 0 && fsync(fileno(file.get())) == 0;
  file.reset();
  if (!written || std::rename(beside.c_str(), path.c_str()) != 0) {
    throw std::runtime_error("cannot write checkpoint " + path);
  }
}

std::optional<LineCheckpoint> load_checkpoint(const std::string& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  const std::vector<uint8_t> bytes((std::istreambuf_iterator<char>(file)),
                                   std::istreambuf_iterator<char>());
  try {
    return decode_checkpoint(bytes);
  } catch (const std::invalid_argument& wrong) {
    throw std::invalid_argument(path + ": " + wrong.what());
  }
}

}  // namespace marco::slam
