#include "tools/map/photographs.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>

#include "bot_core/image_t.hpp"
#include "common/files/ply.hpp"
#include "common/input/pantilt_track.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/log/image_pixels.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "mapping3d/surface/photograph_list.hpp"
#include "tools/map/sibling_program.hpp"

namespace marco {
namespace {

using bot_core::image_t;

// The sensor frame has x ahead and z up; a picture's camera z ahead, x right, y down.
Pose3 sensor_from_camera() {
  Pose3 pose = Pose3::Identity();
  pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return pose;
}

// The content of a picture file; nothing where the message holds no picture.
std::optional<std::string> as_picture_file(const image_t& image, std::string& ending) {
  if (image.pixelformat == image_t::PIXEL_FORMAT_MJPEG) {
    const bool jpeg = image.data.size() > 4 && image.data[0] == 0xFF && image.data[1] == 0xD8 &&
                      image.data[2] == 0xFF;
    ending = ".jpg";
    if (!jpeg) return std::nullopt;
    return std::string(image.data.begin(), image.data.end());
  }
  const auto pixels = plain_pixels(image);
  if (!pixels || image.width < 2 || image.height < 2) return std::nullopt;
  const bool grey = bytes_per_pixel(image) == 1;
  ending = grey ? ".pgm" : ".ppm";
  std::string file = (grey ? "P5\n" : "P6\n") + std::to_string(image.width) + " " +
                     std::to_string(image.height) + "\n255\n";
  return file.append(pixels->begin(), pixels->end());
}

// A picture that was chosen.
struct Taken {
  Pose3 world_from_camera;
  std::string channel;
  double focal_px = 0.0;
  std::string bytes;
  std::string ending;
};

bool shows_the_same(
    const Taken& a, const Pose3& b, const std::string& channel, double part_m, double cosine) {
  return a.channel == channel &&
         (a.world_from_camera.translation() - b.translation()).norm() < part_m &&
         a.world_from_camera.linear().col(2).dot(b.linear().col(2)) > cosine;
}

class Chooser {
 public:
  Chooser(const Trajectory& path,
          const std::map<std::string, SensorInfo>& sensors,
          const PhotographOptions& options)
      : path_(path), sensors_(sensors), options_(options) {
    std::stable_sort(path_.begin(), path_.end(), [](const StampedPose2& a, const StampedPose2& b) {
      return a.utime < b.utime;
    });
  }

  void read(const std::string& recording) {
    files::EventLogReader log(recording);
    PanTiltTrack pantilt(Duration::from_seconds(1.0), Duration::from_seconds(0.1));
    std::deque<image_t> waiting;  // for the pan-tilt angles at their stamps
    std::deque<std::string> channels;
    const auto use_waiting = [&](bool all) {
      while (!waiting.empty() && (all || pantilt.reaches(Utime{waiting.front().utime}))) {
        take(waiting.front(), channels.front(), pantilt.at(Utime{waiting.front().utime}));
        waiting.pop_front();
        channels.pop_front();
      }
    };
    constexpr std::size_t kMostWaiting = 64;  // a pan-tilt that stopped sending delays nothing
    while (const auto head = log.next_head()) {
      const std::string channel(head->channel);
      const bool state = channel == channels::kPanTiltState;
      if (!state && !is_picture(*head)) continue;
      const auto bytes = log.data();
      if (state) {
        note_pantilt(pantilt, channel, bytes);
        use_waiting(false);
        continue;
      }
      image_t image{};
      ++counts_.recorded;
      if (image.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) {
        ++counts_.dropped["truncated message"];
        continue;
      }
      waiting.push_back(std::move(image));
      channels.push_back(channel);
      const auto camera = sensors_.find(channel);
      const bool turned =
          camera != sensors_.end() && camera->second.mount != SensorInfo::Mount::robot;
      use_waiting(!turned || waiting.size() > kMostWaiting);
    }
    use_waiting(true);
  }

  // Drops pictures close to others until at most `most` are left.
  std::vector<Taken> chosen() {
    constexpr double kMostGrown = 1e4;  // then only other cameras are left
    const auto most = static_cast<std::size_t>(options_.most);
    for (double grow = 1.2; taken_.size() > most && grow < kMostGrown; grow *= 1.2) {
      const double part_m = grow * options_.apart_m;
      const double cosine = std::cos(std::min(3.1, grow * deg_to_rad(options_.apart_deg)));
      std::vector<Taken> fewer;
      for (Taken& picture : taken_) {
        const bool known = std::any_of(fewer.begin(), fewer.end(), [&](const Taken& other) {
          return shows_the_same(other, picture.world_from_camera, picture.channel, part_m, cosine);
        });
        if (!known) fewer.push_back(std::move(picture));
      }
      taken_ = std::move(fewer);
    }
    taken_.erase(taken_.begin() + static_cast<std::ptrdiff_t>(std::min(most, taken_.size())),
                 taken_.end());
    counts_.chosen = static_cast<int64_t>(taken_.size());
    return std::move(taken_);
  }

  const PhotographCounts& counts() const { return counts_; }

 private:
  static bool is_picture(const files::LogEventHead& head) {
    if (head.first_bytes.size() < 8) return false;
    uint64_t fingerprint = 0;
    for (std::size_t i = 0; i < 8; ++i) fingerprint = fingerprint << 8 | head.first_bytes[i];
    return fingerprint == static_cast<uint64_t>(image_t::getHash());
  }

  static void note_pantilt(PanTiltTrack& pantilt,
                           const std::string& channel,
                           std::span<const uint8_t> bytes) {
    try {
      const auto sample = decode_sample(channel, bytes);
      if (sample) pantilt.add(std::get<PanTiltState>(*sample));
    } catch (const std::invalid_argument&) {
      return;  // counted by the sweeps
    }
  }

  // Interpolated between two scans, unless they are far apart or the robot turns fast.
  std::optional<Pose2> pose_at(Utime utime, const char*& why) const {
    const auto after =
        std::lower_bound(path_.begin(), path_.end(), utime,
                         [](const StampedPose2& pose, Utime at) { return pose.utime < at; });
    why = "taken where the path is unknown";
    if (after == path_.end() || (after == path_.begin() && after->utime != utime)) {
      return std::nullopt;
    }
    if (after == path_.begin()) return after->world_from_robot;
    const auto before = std::prev(after);
    const double gap_s = (after->utime - before->utime).seconds();
    if (gap_s > options_.max_gap_s) return std::nullopt;
    const Pose2 step = between(before->world_from_robot, after->world_from_robot);
    why = "taken during a fast turn";
    // Between scans in quick succession, matching noise looks like a turn.
    constexpr double kNoiseRad = 0.003;
    if (std::abs(step.theta_rad) > kNoiseRad + gap_s * deg_to_rad(options_.max_turn_deg_per_s)) {
      return std::nullopt;
    }
    const double part = (utime - before->utime).seconds() / std::max(1e-6, gap_s);
    return interpolate(before->world_from_robot, after->world_from_robot, part);
  }

  void take(const image_t& image,
            const std::string& channel,
            const std::optional<PanTiltAngles>& angles) {
    const auto camera = sensors_.find(channel);
    if (camera == sensors_.end() || !(camera->second.focal_length_px > 0.0)) {
      ++counts_.dropped["camera without SENSOR_INFO or focal length"];
      return;
    }
    const SensorInfo& info = camera->second;
    const auto robot_from_camera =
        robot_from_sensor(info, find_sensor(sensors_, channels::kPanTiltState), angles);
    if (!robot_from_camera) {
      ++counts_.dropped["camera without pan-tilt angles"];
      return;
    }
    const char* why = "";
    const auto world_from_robot = pose_at(Utime{image.utime}, why);
    if (!world_from_robot) {
      ++counts_.dropped[why];
      return;
    }
    const Pose3 world_from_camera =
        lift(*world_from_robot) * *robot_from_camera * sensor_from_camera();
    const double cosine = std::cos(deg_to_rad(options_.apart_deg));
    if (std::any_of(taken_.begin(), taken_.end(), [&](const Taken& other) {
          return shows_the_same(other, world_from_camera, channel, options_.apart_m, cosine);
        })) {
      return;
    }
    std::string ending;
    auto bytes = as_picture_file(image, ending);
    if (!bytes) {
      ++counts_.dropped["unknown picture format"];
      return;
    }
    taken_.push_back({world_from_camera, channel, info.focal_length_px, std::move(*bytes), ending});
  }

  Trajectory path_;
  const std::map<std::string, SensorInfo>& sensors_;
  const PhotographOptions& options_;
  std::vector<Taken> taken_;
  PhotographCounts counts_;
};

}  // namespace

PhotographCounts write_photographs(const std::filesystem::path& folder,
                                   const std::vector<std::string>& recordings,
                                   const Trajectory& path,
                                   const std::map<std::string, SensorInfo>& sensors,
                                   const PhotographOptions& options) {
  if (options.most == 0) return {};
  Chooser chooser(path, sensors, options);
  for (const std::string& recording : recordings) chooser.read(recording);
  const std::vector<Taken> chosen = chooser.chosen();
  if (chosen.empty()) return chooser.counts();
  std::filesystem::create_directories(folder / "photographs");
  PhotographList list;
  list.texture = options.texture;
  for (const Taken& picture : chosen) {
    char name[32];
    std::snprintf(name, sizeof name, "photographs/%03zu", list.photographs.size());
    PhotographSpec spec;
    spec.file = name + picture.ending;
    files::write_whole_file(folder / spec.file, picture.bytes);
    const Eigen::Vector3d at = picture.world_from_camera.translation();
    const Eigen::Quaterniond turn(picture.world_from_camera.linear());
    spec.position_m = {at.x(), at.y(), at.z()};
    spec.quaternion_xyzw = {turn.x(), turn.y(), turn.z(), turn.w()};
    spec.focal_px = {picture.focal_px};
    list.photographs.push_back(spec);
  }
  files::write_whole_file(folder / "photographs.toml", process::print_options(list));
  return chooser.counts();
}

std::map<std::string, double> paint_elsewhere(const std::filesystem::path& folder,
                                              const TriangleMesh& mesh,
                                              files::GlbNumbers glb_numbers) {
  const std::string model = (folder / "simplified.part.ply").string();
  const std::string report = (folder / "painted.part.json").string();
  files::write_ply(model, mesh);
  std::vector<std::string> words{
      model,   (folder / "photographs.toml").string(),  "--as-it-is", "--report", report,
      "--out", (folder / "model_textured.glb").string()};
  if (glb_numbers == files::GlbNumbers::compressed) words.push_back("--compressed-glb");
  const int code = run_sibling("marco-texture", words);
  std::filesystem::remove(model);
  std::map<std::string, double> counted;
  if (std::filesystem::exists(report)) {
    counted =
        nlohmann::json::parse(files::read_whole_file(report)).get<std::map<std::string, double>>();
    std::filesystem::remove(report);
  }
  if (code != 0)
    std::fprintf(stderr, "marco-texture failed (exit code %d): the model has no texture\n", code);
  return counted;
}

}  // namespace marco
