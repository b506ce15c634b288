#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/files/glb.hpp"
#include "common/samples.hpp"
#include "common/trajectory.hpp"
#include "mapping3d/surface/texture.hpp"

namespace marco {

struct PhotographOptions {
  int most = 80;            ///< per model; each costs painting time
  double apart_m = 0.6;     ///< a picture is kept if no other was taken within this distance
  double apart_deg = 25.0;  ///< and within this angle
  double max_turn_deg_per_s = 20.0;  ///< faster turns need better stamps than cameras have
  double max_gap_s = 0.5;            ///< between two poses that are interpolated
  mapping3d::TextureOptions texture;

  template <class Visitor>
  void visit(Visitor& v) {
    v("most", most, Limits{0, 10000},
      "Largest number of pictures for texturing the model. Each costs time.");
    v.advanced("apart_m", apart_m, kPositive,
               "A picture is skipped if another was taken within this distance (and apart_deg).");
    v.advanced("apart_deg", apart_deg, Limits{0.1, 180.0},
               "A picture is skipped if another was taken within this angle (and apart_m).");
    v.advanced("max_turn_deg_per_s", max_turn_deg_per_s, kPositive,
               "Pictures taken in faster turns are skipped: their stamps are not exact enough.");
    v("texture", texture);
  }
};

/// Counts of a recording's pictures (bot_core.image_t on any channel).
struct PhotographCounts {
  int64_t recorded = 0;
  int64_t chosen = 0;
  std::map<std::string, int64_t> dropped;  ///< by cause; redundant pictures are not counted
  std::map<std::string, double> painted;   ///< counts of marco-texture, by name with unit
};

/// Chooses pictures of LCM logs that together show the whole scene, and computes their poses from
/// the path, SENSOR_INFO and PANTILT_STATE. Writes them to `folder`/photographs, with the list
/// photographs.toml that `marco texture` reads. Writes nothing when there are none.
/// @param path     of the robot, by the laser's stamps; in any order
/// @param sensors  newest SENSOR_INFO of each channel
PhotographCounts write_photographs(const std::filesystem::path& folder,
                                   const std::vector<std::string>& recordings,
                                   const Trajectory& path,
                                   const std::map<std::string, SensorInfo>& sensors,
                                   const PhotographOptions& options);

/// Has marco-texture paint `mesh` with folder/photographs.toml: model_textured.glb with its atlas
/// model_textured.png. @returns its counts, by name with unit. If it fails, prints so on standard
/// error; the map is complete without it.
std::map<std::string, double> paint_elsewhere(const std::filesystem::path& folder,
                                              const TriangleMesh& mesh,
                                              files::GlbNumbers glb_numbers);

}  // namespace marco
