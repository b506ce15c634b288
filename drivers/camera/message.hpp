#pragma once

#include "bot_core/image_t.hpp"
#include "drivers/camera/source.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::drivers::camera {

inline bot_core::image_t to_message(const Picture& picture, Utime utime) {
  bot_core::image_t message;
  message.utime = utime.us;
  message.width = picture.width_px;
  message.height = picture.height_px;
  message.row_stride = 0;
  message.pixelformat = bot_core::image_t::PIXEL_FORMAT_MJPEG;
  message.data = picture.jpeg;
  message.size = static_cast<int32_t>(picture.jpeg.size());
  message.nmetadata = 0;
  return message;
}

}  // namespace marco::drivers::camera
