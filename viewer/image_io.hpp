#pragma once

#include <string>
#include <string_view>

#include "viewer/picture.hpp"

namespace marco::viewer {

/// Writes a PNG, whole or not at all: it appears under `path` when every byte is on the disk.
/// @throws std::invalid_argument when the picture is empty; std::runtime_error naming the path when
/// it cannot be created or the disk is full.
void write_png(const Picture& picture, const std::string& path);

/// Reads any picture OpenCV knows (PNG, JPEG, PGM ...) as RGB.
/// @throws std::runtime_error naming the path when it is missing or no picture.
Picture read_picture(const std::string& path);

/// The same of a file's bytes. @throws std::invalid_argument when they are not a picture.
Picture decode_picture(std::string_view bytes);

}  // namespace marco::viewer
