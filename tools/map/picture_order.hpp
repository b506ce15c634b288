#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "viewer/scene.hpp"

namespace marco {

/// A picture to be drawn by marco-map-pictures: the renderer and what it stands on take a hundred
/// megabytes, which a map does not need.
struct PictureOrder {
  std::string path;
  bool flat = true;    ///< the map from above, drawn without the renderer
  std::string camera;  ///< as viewer::RenderRequest::camera
  viewer::Scene scene;
};

std::string encode_picture_orders(std::vector<PictureOrder> orders);

/// @throws std::invalid_argument as unseal() and ByteReader.
std::vector<PictureOrder> decode_picture_orders(std::string_view bytes);

/// Writes the orders beside their pictures, has them drawn by marco-map-pictures, which lies where
/// this program lies, and waits. Where the viewer is not built, says so on stderr. @throws
/// std::runtime_error when it could not be started or failed.
void draw_elsewhere(std::vector<PictureOrder> orders, const std::string& orders_path);

}  // namespace marco
