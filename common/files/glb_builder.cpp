#include "common/files/glb_builder.hpp"

#include "lcm_tools/base/check.hpp"

namespace marco::files {
namespace {

using nlohmann::json;

void append_number(std::string& file, std::size_t value) {
  for (unsigned shift = 0; shift < 32; shift += 8) {
    file += static_cast<char>((value >> shift) & 0xFFU);
  }
}

}  // namespace

std::size_t GlbBuilder::append_binary(const void* data, std::size_t bytes) {
  const std::size_t start = binary_.size();
  binary_.append(static_cast<const char*>(data), bytes);
  binary_.resize((binary_.size() + 3) / 4 * 4, '\0');
  return start;
}

std::size_t GlbBuilder::add_view(const void* data, std::size_t bytes, int target) {
  json view = {{"buffer", 0}, {"byteOffset", append_binary(data, bytes)}, {"byteLength", bytes}};
  if (target != 0) view["target"] = target;
  views_.push_back(std::move(view));
  return views_.size() - 1;
}

std::size_t GlbBuilder::add(const void* data, std::size_t bytes, int target, json accessor) {
  accessor["bufferView"] = add_view(data, bytes, target);
  accessors_.push_back(std::move(accessor));
  return accessors_.size() - 1;
}

std::size_t GlbBuilder::add(const PackedNumbers& packed, int target, json accessor) {
  const std::size_t start = append_binary(packed.bytes.data(), packed.bytes.size());
  const std::size_t unpacked = packed.count * packed.stride;
  json view = {{"buffer", 1},
               {"byteOffset", unpacked_bytes_},
               {"byteLength", unpacked},
               {"target", target},
               {"extensions",
                {{kMeshopt,
                  {{"buffer", 0},
                   {"byteOffset", start},
                   {"byteLength", packed.bytes.size()},
                   {"byteStride", packed.stride},
                   {"count", packed.count},
                   {"mode", packed.mode},
                   {"filter", packed.filter}}}}}};
  if (target == kGlbVertices) view["byteStride"] = packed.stride;
  unpacked_bytes_ += (unpacked + 3) / 4 * 4;
  views_.push_back(std::move(view));
  accessor["bufferView"] = views_.size() - 1;
  accessors_.push_back(std::move(accessor));
  return accessors_.size() - 1;
}

std::string GlbBuilder::finish(json document) {
  if (!accessors_.empty()) document["accessors"] = accessors_;
  if (!views_.empty()) document["bufferViews"] = views_;
  if (!binary_.empty()) document["buffers"] = {{{"byteLength", binary_.size()}}};
  if (unpacked_bytes_ > 0) {
    document["buffers"].push_back(
        {{"byteLength", unpacked_bytes_}, {"extensions", {{kMeshopt, {{"fallback", true}}}}}});
    document["extensionsUsed"] = {kMeshopt, "KHR_mesh_quantization"};
    document["extensionsRequired"] = document["extensionsUsed"];
  }
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string file = "glTF";
  const std::size_t total = 12 + 8 + text.size() + (binary_.empty() ? 0 : 8 + binary_.size());
  require(total < 0xFFFFFFFFU, "write_glb: a GLB holds at most 4 GB");
  append_number(file, 2);
  append_number(file, total);
  append_number(file, text.size());
  file += "JSON" + text;
  if (!binary_.empty()) {
    append_number(file, binary_.size());
    file += std::string("BIN\0", 4) + binary_;
  }
  return file;
}

json glb_positions(const std::vector<Eigen::Vector3f>& vertices_m) {
  Eigen::Vector3f low = vertices_m.front(), high = vertices_m.front();
  for (const Eigen::Vector3f& vertex : vertices_m) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  return {{"componentType", kGlbFloat},
          {"count", vertices_m.size()},
          {"type", "VEC3"},
          {"min", {low.x(), low.y(), low.z()}},
          {"max", {high.x(), high.y(), high.z()}}};
}

std::vector<std::array<uint8_t, 4>> glb_colors(
    const std::vector<std::array<uint8_t, 3>>& colors_rgb) {
  std::vector<std::array<uint8_t, 4>> rgba;
  rgba.reserve(colors_rgb.size());
  for (const auto& c : colors_rgb) rgba.push_back({c[0], c[1], c[2], 255});
  return rgba;
}

}  // namespace marco::files
