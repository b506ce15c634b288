#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "viewer/scene.hpp"

namespace marco {

/// A picture to be drawn by marco-map-pictures: the renderer and its libraries take a hundred
/// megabytes, which marco-map itself does not need.
struct PictureOrder {
  std::string path;
  bool flat = true;    ///< a 2D map, drawn without the renderer
  std::string camera;  ///< as viewer::RenderRequest::camera
  viewer::Scene scene;
};

std::string encode_picture_orders(std::vector<PictureOrder> orders);

/// @throws std::invalid_argument as unseal() and ByteReader.
std::vector<PictureOrder> decode_picture_orders(std::string_view bytes);

/// Writes the orders to `orders_path`, runs marco-map-pictures from this program's folder on them,
/// and waits. Prints a note on stderr where the viewer was not built.
/// @throws std::runtime_error when it cannot be started or fails.
void draw_elsewhere(std::vector<PictureOrder> orders, const std::string& orders_path);

}  // namespace marco
