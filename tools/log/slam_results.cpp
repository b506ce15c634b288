#include "tools/log/slam_results.hpp"

#include "bot_core/image_t.hpp"
#include "lcm_tools/log/image_pixels.hpp"
#include "lcm_tools/log/moment.hpp"
#include "lcm_tools/schema/json.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/stamp.hpp"

namespace marco::logs {
namespace {

using lcm_schema::is_a;

// All of ours have their stamp behind the fingerprint, big-endian.
int64_t first_field(std::span<const uint8_t> bytes) {
  uint64_t value = 0;
  for (const uint8_t byte : bytes.subspan(8, 8)) value = value << 8U | byte;
  return static_cast<int64_t>(value);
}

}  // namespace

std::optional<Utime> SlamResults::stamp_of_result(const files::LogEventHead& head) const {
  const std::span<const uint8_t> first = head.first_bytes;
  const bool is_result = is_a<slam_pose_t>(first) || is_a<trajectory_t>(first) ||
                         is_a<grid_map_t>(first) || is_a<bot_core::image_t>(first);
  if (!is_result || first.size() < files::LogEventHead::kFirstBytes) return std::nullopt;
  try {
    return stamp_of(first_field(first));
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

void SlamResults::write_until(Utime utime) {
  while (!ended_) {
    if (due_ && utime < *due_) return;
    if (due_) {
      try {
        write(channel_, log_.data(), event_time_);
      } catch (const std::invalid_argument&) {  // a message that contradicts itself
      }
      due_.reset();
    }
    const auto head = log_.next_head();
    ended_ = !head;
    if (ended_) return write_maps(grids_.finish());
    due_ = stamp_of_result(*head);
    channel_ = head->channel;
    event_time_ = bounded(head->event_time);
  }
}

void SlamResults::write(const std::string& channel,
                        std::span<const uint8_t> bytes,
                        Utime event_time) {
  write_maps(grids_.finished(event_time));
  if (is_a<slam_pose_t>(bytes)) {
    if (channel != channels::kSlamPose) return;
    if (const auto message = decode_message<slam_pose_t>(bytes)) {
      const PoseEstimate estimate = from_message(*message);
      out_.add_slam_pose(estimate.utime, estimate.world_from_robot);
    }
  } else if (is_a<trajectory_t>(bytes)) {
    if (const auto message = decode_message<trajectory_t>(bytes)) {
      out_.add_path(stamp_of(message->utime), from_message(*message));
    }
  } else if (is_a<grid_map_t>(bytes)) {
    if (channel != channels::kGridMap) return;
    if (const auto tile = decode_message<grid_map_t>(bytes)) {
      write_maps(grids_.add(channel, *tile, event_time));
    }
  } else {
    write_image(channel, bytes);
  }
}

void SlamResults::write_maps(const std::vector<JoinedGrid>& maps) {
  for (const JoinedGrid& joined : maps) out_.add_map(stamp_of(joined.utime_us), joined.map);
}

void SlamResults::write_image(const std::string& channel, std::span<const uint8_t> bytes) {
  const auto image = decode_message<bot_core::image_t>(bytes);
  if (!image) return;
  ros::ImageMessage message;
  message.header.stamp_ns = stamp_of(image->utime).us * 1000;
  if (image->pixelformat == bot_core::image_t::PIXEL_FORMAT_MJPEG) {
    message.encoding = "jpeg";
    message.data = image->data;
    return out_.add_image(channel, std::move(message));
  }
  auto pixels = plain_pixels(*image);
  if (!pixels) return;
  const int pixel_bytes = bytes_per_pixel(*image);
  message.encoding = pixel_bytes == 1 ? "mono8" : "rgb8";
  message.width = static_cast<uint32_t>(image->width);
  message.height = static_cast<uint32_t>(image->height);
  message.step_bytes = message.width * static_cast<uint32_t>(pixel_bytes);
  message.data = std::move(*pixels);
  out_.add_image(channel, std::move(message));
}

}  // namespace marco::logs
