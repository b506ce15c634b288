#include "common/files/glb_compression.hpp"

#include <meshoptimizer.h>

#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::files {
namespace {

using nlohmann::json;

// Positions are whole multiples of 2^-10 m, as the filter EXPONENTIAL has them: 24 bits of a
// number and 8 of an exponent. Half such a step is 0.49 mm, and a building of any size has it.
constexpr int kPositionExponent = -10;
constexpr float kMostSteps = 8388607.0F;

// A block of the codec spends two bits on 16 equal bytes.
constexpr std::size_t kMostGrowth = 64;

/// Old vertex to new one, by the order in which triangles use them.
struct VertexOrder {
  std::vector<unsigned> new_of;
  std::size_t count = 0;

  template <class T>
  std::vector<T> apply(const std::vector<T>& values) const {
    std::vector<T> ordered(values.empty() ? 0 : count);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (new_of[i] != ~0U) ordered[new_of[i]] = values[i];
    }
    return ordered;
  }
};

VertexOrder order(std::vector<unsigned>& indices, std::size_t vertices) {
  meshopt_optimizeVertexCache(indices.data(), indices.data(), indices.size(), vertices);
  VertexOrder order{std::vector<unsigned>(vertices), 0};
  order.count = meshopt_optimizeVertexFetchRemap(order.new_of.data(), indices.data(),
                                                 indices.size(), vertices);
  for (unsigned& index : indices) index = order.new_of[index];
  return order;
}

template <class T>
PackedNumbers pack(const std::vector<T>& values, const char* filter = "NONE") {
  meshopt_encodeVertexVersion(0);  // the only one of the extension
  PackedNumbers packed{{}, values.size(), sizeof(T), "ATTRIBUTES", filter};
  packed.bytes.resize(meshopt_encodeVertexBufferBound(values.size(), sizeof(T)));
  packed.bytes.resize(
      meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(packed.bytes.data()),
                                 packed.bytes.size(), values.data(), values.size(), sizeof(T)));
  return packed;
}

PackedNumbers pack_triangles(const std::vector<unsigned>& indices, std::size_t vertices) {
  meshopt_encodeIndexVersion(1);  // the only one of the extension
  PackedNumbers packed{{}, indices.size(), sizeof(unsigned), "TRIANGLES", "NONE"};
  packed.bytes.resize(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  packed.bytes.resize(
      meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(packed.bytes.data()),
                                packed.bytes.size(), indices.data(), indices.size()));
  return packed;
}

std::size_t add_rounded_positions(GlbBuilder& builder, std::vector<Eigen::Vector3f> vertices_m) {
  std::vector<std::array<uint32_t, 3>> words(vertices_m.size());
  for (std::size_t i = 0; i < vertices_m.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      float& at_m = vertices_m[i](axis);
      const float steps = std::round(std::ldexp(at_m, -kPositionExponent));
      require(std::abs(steps) <= kMostSteps, "write_glb: a position is not within 8 km");
      at_m = std::ldexp(steps, kPositionExponent);
      words[i][static_cast<std::size_t>(axis)] =
          static_cast<uint32_t>(kPositionExponent) << 24U |
          (static_cast<uint32_t>(static_cast<int32_t>(steps)) & 0xFFFFFFU);
    }
  }
  return builder.add(pack(words, "EXPONENTIAL"), kGlbVertices, glb_positions(vertices_m));
}

std::size_t add_rounded_normals(GlbBuilder& builder, const std::vector<Eigen::Vector3f>& normals) {
  std::vector<std::array<float, 4>> wide;
  wide.reserve(normals.size());
  for (const Eigen::Vector3f& n : normals) wide.push_back({n.x(), n.y(), n.z(), 0.0F});
  std::vector<std::array<int8_t, 4>> bytes(normals.size());
  meshopt_encodeFilterOct(bytes.data(), bytes.size(), sizeof bytes[0], 8, wide[0].data());
  return builder.add(pack(bytes, "OCTAHEDRAL"), kGlbVertices,
                     {{"componentType", kGlbByte},
                      {"normalized", true},
                      {"count", bytes.size()},
                      {"type", "VEC3"}});
}

std::size_t add_rounded_uvs(GlbBuilder& builder, const std::vector<Eigen::Vector2f>& uvs) {
  std::vector<std::array<uint16_t, 2>> shorts;
  shorts.reserve(uvs.size());
  for (const Eigen::Vector2f& uv : uvs) {
    require(uv.minCoeff() >= 0.0F && uv.maxCoeff() <= 1.0F, "write_glb: a uv is not in 0..1");
    const auto part = [](float of) { return static_cast<uint16_t>(std::lround(65535.0F * of)); };
    shorts.push_back({part(uv.x()), part(uv.y())});
  }
  return builder.add(pack(shorts), kGlbVertices,
                     {{"componentType", kGlbUnsignedShort},
                      {"normalized", true},
                      {"count", shorts.size()},
                      {"type", "VEC2"}});
}

void unfilter(std::string& bytes,
              const std::string& filter,
              std::size_t count,
              std::size_t stride) {
  if (filter == "NONE") return;
  if (filter == "OCTAHEDRAL") {
    require(stride == 4 || stride == 8, "has normals of an unknown width");
    meshopt_decodeFilterOct(bytes.data(), count, stride);
  } else {
    require(filter == "EXPONENTIAL", "is compressed by an unknown filter");
    meshopt_decodeFilterExp(bytes.data(), count, stride);
  }
}

}  // namespace

json compressed_numbers(GlbBuilder& builder,
                        const TriangleMesh& mesh,
                        const std::vector<Eigen::Vector2f>& uvs) {
  std::vector<unsigned> indices;
  indices.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    indices.insert(indices.end(), triangle.begin(), triangle.end());
  }
  const VertexOrder used = order(indices, mesh.vertices_m.size());
  json attributes;
  attributes["POSITION"] = add_rounded_positions(builder, used.apply(mesh.vertices_m));
  if (!mesh.normals.empty()) {
    attributes["NORMAL"] = add_rounded_normals(builder, used.apply(mesh.normals));
  }
  if (!mesh.colors_rgb.empty()) {
    attributes["COLOR_0"] = builder.add(pack(glb_colors(used.apply(mesh.colors_rgb))), kGlbVertices,
                                        {{"componentType", kGlbUnsignedByte},
                                         {"normalized", true},
                                         {"count", used.count},
                                         {"type", "VEC4"}});
  }
  if (!uvs.empty()) attributes["TEXCOORD_0"] = add_rounded_uvs(builder, used.apply(uvs));
  const std::size_t triangles = builder.add(
      pack_triangles(indices, used.count), kGlbIndices,
      {{"componentType", kGlbUnsignedInt}, {"count", indices.size()}, {"type", "SCALAR"}});
  return {{"attributes", attributes}, {"indices", triangles}};
}

std::string unpacked(std::string_view packed, const json& how) {
  const auto count = how.at("count").get<std::size_t>();
  const auto stride = how.at("byteStride").get<std::size_t>();
  const auto mode = how.at("mode").get<std::string>();
  require(stride > 0 && stride <= 256 && stride % 4 == 0 &&
              count <= kMostGrowth * packed.size() / stride,
          "ends inside its compressed numbers");
  std::string bytes(count * stride, '\0');
  const auto* from = reinterpret_cast<const unsigned char*>(packed.data());
  int fault = 0;
  if (mode == "TRIANGLES") {
    require(stride == sizeof(unsigned) && count % 3 == 0, "has triangles in an unknown form");
    fault = meshopt_decodeIndexBuffer(bytes.data(), count, stride, from, packed.size());
  } else {
    require(mode == "ATTRIBUTES", "is compressed in an unknown way");
    fault = meshopt_decodeVertexBuffer(bytes.data(), count, stride, from, packed.size());
    if (fault == 0) unfilter(bytes, how.value("filter", std::string("NONE")), count, stride);
  }
  require(fault == 0, "has damaged compressed numbers");
  return bytes;
}

}  // namespace marco::files
