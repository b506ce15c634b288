#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "common/files/obj.hpp"
#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"

namespace marco::files {
namespace {

constexpr std::array kPassedOver = {"vt", "vp", "o", "g", "s", "mg", "usemtl", "mtllib", "p", "l"};

class ObjReader {
 public:
  explicit ObjReader(const std::filesystem::path& path) : path_(path), file_(open_readable(path)) {
    require(file_.is_open() && !std::filesystem::is_directory(path),
            path.string() + ": cannot be read");
  }

  TriangleMesh read() {
    std::string line;
    while (read_line(file_, line)) {
      ++line_;
      take(std::string_view(line).substr(0, line.find('#')));
    }
    return finish();
  }

 private:
  void check(bool holds, const std::string& complaint) const {
    if (!holds) fail(complaint);
  }
  [[noreturn]] void fail(const std::string& complaint) const {
    throw std::invalid_argument(path_.string() + ":" + std::to_string(line_) + ": " + complaint);
  }

  void take(std::string_view line) {
    TextFields fields(line);
    const std::string_view word = fields.next();
    if (word.empty()) return;
    if (word == "v") {
      take_vertex(fields);
    } else if (word == "vn") {
      given_normals_.push_back(direction(fields));
    } else if (word == "f") {
      take_face(fields);
    } else if (std::find(kPassedOver.begin(), kPassedOver.end(), word) == kPassedOver.end()) {
      fail("'" + std::string(word.substr(0, 20)) + "' is not a supported OBJ line");
    }
  }

  float number(std::string_view field) const {
    const auto value = TextFields(field).number<float>();
    check(value && std::isfinite(*value),
          "'" + std::string(field.substr(0, 20)) + "' is not a finite number");
    return *value;
  }

  Eigen::Vector3f direction(TextFields& fields) const {
    Eigen::Vector3f read;
    for (int axis = 0; axis < 3; ++axis) read(axis) = number(fields.next());
    return read;
  }

  void take_vertex(TextFields& fields) {
    std::array<float, 6> read{};
    std::size_t count = 0;
    for (auto field = fields.next(); !field.empty(); field = fields.next()) {
      check(count < read.size(), "a vertex has at most x y z and r g b");
      read[count++] = number(field);
    }
    check(count == 3 || count == 4 || count == 6, "a vertex has x y z, and perhaps r g b");
    check(mesh_.vertices_m.size() < 0xFFFFFFFFU, "has more than 4294967295 vertices");
    mesh_.vertices_m.emplace_back(read[0], read[1], read[2]);
    if (count == 6) take_color(read[3], read[4], read[5]);
  }

  void take_color(float red, float green, float blue) {
    const auto byte = [this](float part) {
      check(part >= 0.0F && part <= 1.0F, "a colour's components are 0 to 1");
      return static_cast<uint8_t>(std::lround(255.0F * part));
    };
    mesh_.colors_rgb.push_back({byte(red), byte(green), byte(blue)});
  }

  // Counted from 1, or backwards from the newest.
  uint32_t index(std::string_view field, std::size_t count, const char* of) const {
    const auto given = TextFields(field).number<int64_t>();
    const auto all = static_cast<int64_t>(count);
    check(given && *given != 0 && *given <= all && *given >= -all,
          "'" + std::string(field.substr(0, 20)) + "' is not one of the " + std::to_string(count) +
              " " + of + " before it");
    return static_cast<uint32_t>(*given > 0 ? *given - 1 : all + *given);
  }

  // i, i/j, i//k or i/j/k.
  uint32_t take_corner(std::string_view corner) {
    const std::size_t first = std::min(corner.find('/'), corner.size());
    const uint32_t vertex = index(corner.substr(0, first), mesh_.vertices_m.size(), "vertices");
    const std::size_t second = corner.find('/', first + 1);
    if (second == std::string_view::npos) return vertex;
    const Eigen::Vector3f& normal =
        given_normals_[index(corner.substr(second + 1), given_normals_.size(), "normals")];
    sums_.resize(std::max<std::size_t>(sums_.size(), vertex + 1U), Eigen::Vector3f::Zero());
    sums_[vertex] += normal;
    return vertex;
  }

  void take_face(TextFields& fields) {
    std::array<uint32_t, 3> fan{};
    std::size_t corners = 0;
    for (auto field = fields.next(); !field.empty(); field = fields.next(), ++corners) {
      const uint32_t vertex = take_corner(field);
      if (corners >= 3) fan[1] = fan[2];
      fan[std::min<std::size_t>(corners, 2)] = vertex;
      if (corners >= 2) mesh_.triangles.push_back(fan);
    }
    check(corners >= 3, "a face has at least three corners");
  }

  // A vertex of no triangle gets any direction.
  TriangleMesh finish() {
    if (mesh_.colors_rgb.size() != mesh_.vertices_m.size()) mesh_.colors_rgb.clear();
    sums_.resize(mesh_.vertices_m.size(), Eigen::Vector3f::Zero());
    bool all = !given_normals_.empty();
    for (const auto& triangle : mesh_.triangles) {
      for (const uint32_t vertex : triangle) all = all && !sums_[vertex].isZero(0.0F);
    }
    if (all) {
      for (Eigen::Vector3f& sum : sums_) {
        sum = sum.isZero(0.0F) ? Eigen::Vector3f(Eigen::Vector3f::UnitZ()) : sum.normalized();
      }
      mesh_.normals = std::move(sums_);
    }
    return std::move(mesh_);
  }

  std::filesystem::path path_;
  std::ifstream file_;
  std::size_t line_ = 0;
  TriangleMesh mesh_;
  std::vector<Eigen::Vector3f> given_normals_;
  std::vector<Eigen::Vector3f> sums_;  ///< of each vertex's normals in the faces so far
};

}  // namespace

TriangleMesh read_obj(const std::filesystem::path& path) { return ObjReader(path).read(); }

}  // namespace marco::files
