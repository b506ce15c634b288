#include "web/foxglove/scene.hpp"

#include <algorithm>
#include <cmath>

#include "web/foxglove/json.hpp"

namespace marco::foxglove {
namespace {

// Finer than a laser measures.
std::string millimetres(float metres) { return number(std::round(1e3F * metres) / 1e3F); }

bool is_sound(const mesh_t& tile) {
  return std::all_of(tile.triangles.begin(), tile.triangles.end(), [&](const auto& corners) {
    return std::all_of(corners.begin(), corners.end(),
                       [&](int32_t corner) { return corner >= 0 && corner < tile.num_vertices; });
  });
}

std::string entity_id(const std::string& channel, int32_t tile) {
  return text_json(channel + "/" + std::to_string(tile));
}

std::string triangles_json(const mesh_t& tile) {
  std::string json = R"({"pose":)" + pose_json(Pose3::Identity()) + R"(,"points":[)";
  for (const auto& vertex : tile.vertices_m) {
    json += (json.back() == '[' ? R"({"x":)" : R"(,{"x":)") + millimetres(vertex[0]) + R"(,"y":)" +
            millimetres(vertex[1]) + R"(,"z":)" + millimetres(vertex[2]) + "}";
  }
  json += R"(],"color":{"r":0.75,"g":0.75,"b":0.75,"a":1},"colors":[],"indices":[)";
  for (const auto& corners : tile.triangles) {
    for (const int32_t corner : corners) {
      json += (json.back() == '[' ? "" : ",") + std::to_string(corner);
    }
  }
  return json + "]}";
}

}  // namespace

std::string SceneUpdates::json(const std::string& channel,
                               const std::string& stamp,
                               const std::string& frame,
                               const mesh_t& tile) {
  if (!is_sound(tile)) return "";
  constexpr int32_t kMostTiles = 100000;  // of a message that lies
  const int32_t tiles = std::clamp(tile.tiles, 0, kMostTiles);
  int32_t& before = tiles_[channel];
  std::string json = R"({"deletions":[)";
  for (int32_t gone = tiles; gone < before; ++gone) {
    json +=
        (gone > tiles ? ",{" : "{") + stamp + R"(,"type":0,"id":)" + entity_id(channel, gone) + "}";
  }
  before = tiles;
  json += R"(],"entities":[{)" + stamp + R"(,"frame_id":)" + text_json(frame) + R"(,"id":)" +
          entity_id(channel, tile.tile) +
          R"(,"lifetime":{"sec":0,"nsec":0},"frame_locked":false,"metadata":[],"arrows":[],)"
          R"("cubes":[],"spheres":[],"cylinders":[],"lines":[],"triangles":[)" +
          triangles_json(tile) + R"(],"texts":[],"models":[]}]})";
  return json;
}

}  // namespace marco::foxglove
