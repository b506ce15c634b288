#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace marco::files {

// Numbers of the glTF 2.0 specification.
constexpr int kGlbByte = 5120, kGlbUnsignedByte = 5121, kGlbUnsignedShort = 5123;
constexpr int kGlbUnsignedInt = 5125, kGlbFloat = 5126;
constexpr int kGlbVertices = 34962, kGlbIndices = 34963;
constexpr const char* kMeshopt = "EXT_meshopt_compression";

/// Numbers in a form that takes less room, and how a reader gets them back: a bufferView of
/// EXT_meshopt_compression.
struct PackedNumbers {
  std::string bytes;
  std::size_t count = 0;   ///< of elements, once unpacked
  std::size_t stride = 0;  ///< [bytes] of each of them
  const char* mode = "ATTRIBUTES";
  const char* filter = "NONE";
};

/// The parts of a GLB in order of their addition.
class GlbBuilder {
 public:
  /// @param accessor  all but its bufferView. @returns the number of the new accessor.
  std::size_t add(const void* data, std::size_t bytes, int target, nlohmann::json accessor);
  std::size_t add(const PackedNumbers& packed, int target, nlohmann::json accessor);
  /// @returns the number of the new bufferView.
  std::size_t add_view(const void* data, std::size_t bytes, int target);

  /// The whole file. @throws std::invalid_argument beyond 4 GB.
  std::string finish(nlohmann::json document);

 private:
  std::size_t append_binary(const void* data, std::size_t bytes);

  nlohmann::json accessors_ = nlohmann::json::array();
  nlohmann::json views_ = nlohmann::json::array();
  std::string binary_;
  std::size_t unpacked_bytes_ = 0;  ///< of all packed numbers, in a buffer that no file holds
};

/// The box of the positions, as an accessor says it.
nlohmann::json glb_positions(const std::vector<Eigen::Vector3f>& vertices_m);

/// A vertex's colour starts at a multiple of four bytes: with an alpha.
std::vector<std::array<uint8_t, 4>> glb_colors(
    const std::vector<std::array<uint8_t, 3>>& colors_rgb);

}  // namespace marco::files
