#include "tests/experiments/figures/thesis_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "lcm_tools/base/check.hpp"
#include "viewer/film.hpp"
#include "viewer/image_io.hpp"
#include "viewer/model_picture.hpp"

namespace marco {
namespace {

using mapping3d::ScenePoints;

// Corners in order round the polygon, each with the normal of its own two edges: of a triangle
// they are all the same.
template <std::size_t N>
void add_polygon(const ScenePoints& scene,
                 const std::array<uint32_t, N>& polygon,
                 TriangleMesh& mesh) {
  const auto first = static_cast<uint32_t>(mesh.vertices_m.size());
  const Eigen::Vector3f& origin = scene.origins_m[polygon[0] / scene.columns];
  for (std::size_t i = 0; i < N; ++i) {
    const Eigen::Vector3f& here = scene.points_m[polygon[i]];
    const Eigen::Vector3f& next = scene.points_m[polygon[(i + 1) % N]];
    const Eigen::Vector3f& last = scene.points_m[polygon[(i + N - 1) % N]];
    const Eigen::Vector3f normal = (next - here).cross(last - here).normalized();
    mesh.vertices_m.push_back(here);
    mesh.normals.emplace_back(normal.dot(origin - here) < 0.0F ? Eigen::Vector3f(-normal) : normal);
  }
  for (uint32_t i = 2; i < N; ++i) mesh.triangles.push_back({first, first + i - 1, first + i});
}

enum class Polygons { triangles, quads };

class Drawer {
 public:
  Drawer(const std::filesystem::path& folder, const FigureOptions& options)
      : folder_(folder), options_(options) {}

  /// @param sweeps drawn in one picture, lit from the first one's laser
  void add(const std::string& file,
           const std::string& what,
           const std::vector<ScenePoints>& sweeps,
           Polygons polygons,
           const viewer::Camera& camera) {
    viewer::Scene scene;
    std::size_t count = 0;
    for (const ScenePoints& sweep : sweeps) {
      const bool quads = polygons == Polygons::quads;
      TriangleMesh mesh =
          quads ? quads_as_triangles(sweep, options_.rule) : flat_triangles(sweep, options_.rule);
      count += mesh.triangles.size() / (quads ? 2 : 1);
      scene.meshes.push_back({std::make_shared<const TriangleMesh>(std::move(mesh))});
    }
    draw({file, what + ": " + std::to_string(count) +
                    (polygons == Polygons::quads ? " quads" : " triangles")},
         scene, camera, options_.mode, sweeps.front());
  }

  void add_points(const ScenePoints& sweep, const viewer::Camera& camera) {
    viewer::Scene scene;
    viewer::PointsItem points{{}, {242, 242, 242}, ""};
    for (std::size_t i = 0; i < sweep.points_m.size(); ++i) {
      if (sweep.valid[i] != 0) points.points_m.push_back(sweep.points_m[i]);
    }
    const std::string count = std::to_string(points.points_m.size());
    scene.points.push_back(std::move(points));
    draw({"5_13_vertices.png", "5.13, one sweep, vertices: " + count + " of " +
                                   std::to_string(sweep.points_m.size()) + " beams"},
         scene, camera, viewer::Mode::points, sweep);
  }

  std::vector<Figure> finish() {
    viewer::write_png(viewer::contact_sheet(pictures_, 3), (folder_ / "figures.png").string());
    return std::move(figures_);
  }

 private:
  void draw(const Figure& figure,
            const viewer::Scene& scene,
            const viewer::Camera& camera,
            viewer::Mode mode,
            const ScenePoints& lit_by) {
    viewer::Look look = viewer::thesis_look(mode);
    look.lamp_m = lit_by.origins_m.front().cast<double>();
    renderer_.load(scene);
    const viewer::Picture picture = renderer_.draw(camera, look, options_.size);
    viewer::write_png(picture, (folder_ / figure.file).string());
    pictures_.push_back(picture);
    figures_.push_back(figure);
  }

  std::filesystem::path folder_;
  FigureOptions options_;
  viewer::Renderer renderer_;
  std::vector<viewer::Picture> pictures_;
  std::vector<Figure> figures_;
};

// How far up and down the middle beam went.
float tilted_rad(const ScenePoints& sweep) {
  float low_rad = 10.0F, high_rad = -10.0F;
  for (std::size_t row = 0; row < sweep.rows; ++row) {
    const std::size_t middle = sweep.index(row, sweep.columns / 2);
    if (sweep.valid[middle] == 0) continue;
    const Eigen::Vector3f beam = sweep.points_m[middle] - sweep.origins_m[row];
    const float elevation_rad = std::atan2(beam.z(), beam.head<2>().norm());
    low_rad = std::min(low_rad, elevation_rad);
    high_rad = std::max(high_rad, elevation_rad);
  }
  return std::max(0.0F, high_rad - low_rad);
}

// A robot also turns and levels its laser between sweeps, which gives short or flat ones.
float most_tilted_rad(const std::vector<ScenePoints>& sweeps) {
  float most_rad = 0.0F;
  for (const ScenePoints& sweep : sweeps) most_rad = std::max(most_rad, tilted_rad(sweep));
  return most_rad;
}

// Of full tilt, as most of the stop.
bool is_full(const ScenePoints& sweep, const std::vector<ScenePoints>& stop) {
  return tilted_rad(sweep) >= 0.9F * most_tilted_rad(stop);
}

float range_m(const ScenePoints& sweep, std::size_t i) {
  return (sweep.points_m[i] - sweep.origins_m[i / sweep.columns]).norm();
}

// Where the most edges of near things lie together: both ways to make polygons differ there.
Eigen::Vector3d place_of_edges(const ScenePoints& sweep) {
  constexpr std::size_t kParts = 12;                 // a part is a twelfth of the rows and columns
  constexpr float kStepM = 0.15F, kNearestM = 0.7F;  // nearer is often the robot itself
  std::array<float, kParts * kParts> weights{};
  std::array<Eigen::Vector3d, kParts * kParts> sums;
  sums.fill(Eigen::Vector3d::Zero());
  for (std::size_t row = 0; row < sweep.rows; ++row) {
    for (std::size_t column = 0; column + 1 < sweep.columns; ++column) {
      const std::size_t i = sweep.index(row, column);
      if (sweep.valid[i] == 0 || sweep.valid[i + 1] == 0) continue;
      const float here_m = range_m(sweep, i), next_m = range_m(sweep, i + 1);
      const float near_m = std::min(here_m, next_m);
      if (std::abs(here_m - next_m) < kStepM || near_m < kNearestM) continue;
      const std::size_t part = row * kParts / sweep.rows * kParts + column * kParts / sweep.columns;
      const float weight = std::pow(near_m, -4.0F);  // near things are seen by many beams
      weights.at(part) += weight;
      sums.at(part) +=
          static_cast<double>(weight) * sweep.points_m[here_m < next_m ? i : i + 1].cast<double>();
    }
  }
  const auto most = std::max_element(weights.begin(), weights.end());
  const Eigen::Vector3d laser = sweep.origins_m[sweep.rows / 2].cast<double>();
  if (!(*most > 0.0F)) return laser + 2.0 * ahead_of(sweep);
  return sums.at(static_cast<std::size_t>(most - weights.begin())) / static_cast<double>(*most);
}

// From beside the laser, nearer and at a slant: what lies behind an edge is seen too.
viewer::Camera zoom_on(const ScenePoints& sweep, const Eigen::Vector3d& place_m) {
  const Eigen::Vector3d laser = sweep.origins_m[sweep.rows / 2].cast<double>();
  const Eigen::Vector3d way = place_m - laser;
  const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(way);
  viewer::Camera camera;
  camera.eye_m = laser + 0.3 * way + 0.25 * left + 0.2 * Eigen::Vector3d::UnitZ();
  camera.target_m = place_m;
  camera.field_of_view_rad = deg_to_rad(40.0);
  return camera;
}

viewer::Camera camera_from(const ScenePoints& sweep, double back_m, double up_m) {
  const Eigen::Vector3d laser = sweep.origins_m[sweep.rows / 2].cast<double>();
  const Eigen::Vector3d ahead = ahead_of(sweep);
  viewer::Camera camera;
  camera.eye_m = laser - back_m * ahead + up_m * Eigen::Vector3d::UnitZ();
  camera.target_m = laser + 2.0 * ahead;
  return camera;
}

// From outside and above, far enough to see it all.
viewer::Camera camera_over(const std::vector<ScenePoints>& sweeps, double aspect) {
  viewer::Box box;
  for (const ScenePoints& sweep : sweeps) {
    for (std::size_t i = 0; i < sweep.points_m.size(); ++i) {
      if (sweep.valid[i] != 0) box.add(sweep.points_m[i].cast<double>());
    }
  }
  viewer::Camera camera;
  camera.field_of_view_rad = deg_to_rad(50.0);
  return viewer::fit_camera(camera, box, deg_to_rad(-70.0), deg_to_rad(55.0), aspect);
}

// Seen from outside a ceiling is in the way: beams that go up are left out.
ScenePoints without_ceiling(ScenePoints sweep) {
  constexpr float kAboveLaserM = 1.1F;
  for (std::size_t i = 0; i < sweep.points_m.size(); ++i) {
    const float up_m = sweep.points_m[i].z() - sweep.origins_m[i / sweep.columns].z();
    if (up_m > kAboveLaserM) sweep.valid[i] = 0;
  }
  return sweep;
}

std::vector<ScenePoints> open_above(const std::vector<ScenePoints>& sweeps) {
  std::vector<ScenePoints> open;
  open.reserve(sweeps.size());
  for (const ScenePoints& sweep : sweeps) open.push_back(without_ceiling(sweep));
  return open;
}

}  // namespace

Eigen::Vector3d ahead_of(const ScenePoints& sweep) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < sweep.points_m.size(); ++i) {
    if (sweep.valid[i] == 0) continue;
    sum += (sweep.points_m[i] - sweep.origins_m[i / sweep.columns]).cast<double>().normalized();
  }
  sum.z() = 0.0;
  return sum.norm() > 0.0 ? Eigen::Vector3d(sum.normalized()) : Eigen::Vector3d::UnitX();
}

// The thesis takes one each 90 deg; a robot that also stands there later takes more.
std::vector<ScenePoints> four_ways(const std::vector<ScenePoints>& stop) {
  constexpr double kOtherWay = 0.5;  // cosine: the pan may miss 90 deg by 30
  std::vector<ScenePoints> chosen;
  for (const ScenePoints& sweep : stop) {
    const bool is_new = std::all_of(chosen.begin(), chosen.end(), [&](const ScenePoints& other) {
      return ahead_of(other).dot(ahead_of(sweep)) < kOtherWay;
    });
    if (is_new && chosen.size() < 4 && is_full(sweep, stop)) chosen.push_back(sweep);
  }
  return chosen;
}

ScenePoints without_ends(ScenePoints scene, int count) {
  const std::size_t cut = std::min(static_cast<std::size_t>(std::max(0, count)), scene.columns);
  for (std::size_t row = 0; row < scene.rows; ++row) {
    for (std::size_t i = 0; i < cut; ++i) {
      scene.valid[scene.index(row, i)] = 0;
      scene.valid[scene.index(row, scene.columns - 1 - i)] = 0;
    }
  }
  return scene;
}

TriangleMesh flat_triangles(const ScenePoints& scene, const mapping3d::ThesisMeshOptions& rule) {
  TriangleMesh mesh;
  for (const auto& triangle : thesis_triangles(scene, rule)) add_polygon(scene, triangle, mesh);
  return mesh;
}

TriangleMesh quads_as_triangles(const ScenePoints& scene,
                                const mapping3d::ThesisMeshOptions& rule) {
  TriangleMesh mesh;
  for (const auto& quad : thesis_quads(scene, rule)) add_polygon(scene, quad, mesh);
  return mesh;
}

std::vector<std::vector<ScenePoints>> by_stop(const std::vector<mapping3d::Scene>& scenes,
                                              double apart_m) {
  std::vector<std::vector<ScenePoints>> stops;
  Eigen::Vector2d last_m = Eigen::Vector2d::Zero();
  for (const mapping3d::Scene& scene : scenes) {
    const Eigen::Vector2d here_m = scene.rows.front().world_from_robot.translation_m();
    if (stops.empty() || (here_m - last_m).norm() > apart_m) stops.emplace_back();
    last_m = here_m;
    stops.back().push_back(place(scene));
  }
  return stops;
}

std::vector<Figure> draw_thesis_figures(const std::filesystem::path& folder,
                                        const std::vector<std::vector<ScenePoints>>& stops,
                                        const FigureOptions& options) {
  require(!stops.empty(), "figures: there is no sweep to draw");
  std::filesystem::create_directories(folder);
  std::vector<std::vector<ScenePoints>> cut = stops;
  for (auto& stop : cut) {
    for (ScenePoints& sweep : stop) sweep = without_ends(std::move(sweep), options.cut_ends);
  }
  Drawer drawer(folder, options);
  const std::vector<ScenePoints> four = four_ways(cut[0]);
  const ScenePoints& one = four.front();
  const viewer::Camera shoulder = camera_from(one, 0.8, 0.6);
  const viewer::Camera zoom = zoom_on(one, place_of_edges(one));
  drawer.add_points(one, shoulder);
  drawer.add("5_14_triangles.png", "5.14, one sweep", {one}, Polygons::triangles, shoulder);
  drawer.add("5_15_quads.png", "5.15, one sweep", {one}, Polygons::quads, shoulder);
  drawer.add("5_16a_triangles.png", "5.16 a, closer", {one}, Polygons::triangles, zoom);
  drawer.add("5_16b_quads.png", "5.16 b, closer", {one}, Polygons::quads, zoom);
  drawer.add("5_17_stop.png",
             "5.17, " + std::to_string(four.size()) + " sweeps of the first stop, one each 90 deg",
             four, Polygons::triangles, camera_from(one, 1.2, 0.7));
  std::vector<ScenePoints> both = open_above(cut[0]);
  const std::size_t other = std::min<std::size_t>(1, cut.size() - 1);
  const std::vector<ScenePoints> second = open_above(cut[other]);
  if (other > 0) both.insert(both.end(), second.begin(), second.end());
  const viewer::Camera over = camera_over(both, options.size.aspect());
  drawer.add("5_19_first_stop.png", "5.19, the first stop from above, beams that rise left out",
             open_above(cut[0]), Polygons::triangles, over);
  if (other > 0) {
    drawer.add("5_20_second_stop.png", "5.20, the second stop", second, Polygons::triangles, over);
    drawer.add("5_21_both.png", "5.21, both by the robot's path", both, Polygons::triangles, over);
  }
  return drawer.finish();
}

}  // namespace marco
