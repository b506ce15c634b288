#include "tools/map/picture_order.hpp"

#include <cstdio>
#include <stdexcept>

#include "common/byte_archive.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "tools/map/sibling_program.hpp"

namespace marco {
namespace {

constexpr std::string_view kName = "MARCOPIC";
constexpr uint32_t kVersion = 1;

// Numbers as they are in memory: reader and writer are of one build.
template <class Archive, class T>
void archive_plain(Archive& bytes, std::vector<T>& values) {
  values.resize(bytes.length(values.size(), sizeof(T)));
  bytes.raw(values.data(), values.size() * sizeof(T));
}

template <class Archive>
void archive_color(Archive& bytes, viewer::Rgb& color) {
  archive(bytes, color.red);
  archive(bytes, color.green);
  archive(bytes, color.blue);
}

template <class Archive>
void archive_scene(Archive& bytes, viewer::Scene& scene) {
  archive(bytes, scene.grid);
  const auto list = [&bytes](auto& items, const auto& fields) {
    items.resize(bytes.length(items.size(), 1));
    for (auto& item : items) fields(item);
  };
  list(scene.meshes, [&bytes](viewer::MeshItem& item) {
    TriangleMesh mesh;
    if constexpr (!Archive::kReads) mesh = *item.mesh;
    archive_plain(bytes, mesh.vertices_m);
    archive_plain(bytes, mesh.normals);
    archive_plain(bytes, mesh.colors_rgb);
    archive_plain(bytes, mesh.triangles);
    archive_color(bytes, item.color);
    if constexpr (Archive::kReads) item.mesh = std::make_shared<TriangleMesh>(std::move(mesh));
  });
  list(scene.points, [&bytes](viewer::PointsItem& item) {
    archive_plain(bytes, item.points_m);
    archive_color(bytes, item.color);
    archive(bytes, item.label);
  });
  list(scene.paths, [&bytes](viewer::PathItem& item) {
    archive_plain(bytes, item.poses);
    archive_color(bytes, item.color);
    archive(bytes, item.label);
  });
  list(scene.walls, [&bytes](viewer::WallItem& item) {
    archive(bytes, item.from_m);
    archive(bytes, item.to_m);
    archive(bytes, item.height_m);
    archive_color(bytes, item.color);
  });
  list(scene.robots, [&bytes](viewer::RobotItem& item) {
    archive(bytes, item.world_from_robot);
    archive(bytes, item.radius_m);
    archive(bytes, item.height_m);
    archive_color(bytes, item.color);
  });
  list(scene.ellipses, [&bytes](viewer::EllipseItem& item) {
    archive(bytes, item.center_m);
    archive(bytes, item.covariance_m2);
    archive(bytes, item.sigmas);
    archive_color(bytes, item.color);
  });
}

template <class Archive>
void archive_orders(Archive& bytes, std::vector<PictureOrder>& orders) {
  orders.resize(bytes.length(orders.size(), 1));
  for (PictureOrder& order : orders) {
    archive(bytes, order.path);
    archive(bytes, order.flat);
    archive(bytes, order.camera);
    archive_scene(bytes, order.scene);
  }
}

}  // namespace

template <class Archive>
void archive(Archive& bytes, GridMap& grid) {
  archive(bytes, grid.origin_m);
  archive(bytes, grid.resolution_m);
  archive(bytes, grid.width_cells);
  archive(bytes, grid.height_cells);
  archive_plain(bytes, grid.occupancy);
}

std::string encode_picture_orders(std::vector<PictureOrder> orders) {
  ByteWriter writer;
  archive_orders(writer, orders);
  return seal(kName, kVersion, writer.take());
}

std::vector<PictureOrder> decode_picture_orders(std::string_view bytes) {
  ByteReader reader(unseal(kName, kVersion, bytes));
  std::vector<PictureOrder> orders;
  archive_orders(reader, orders);
  require(reader.left() == 0, "has trailing bytes");
  return orders;
}

void draw_elsewhere(std::vector<PictureOrder> orders, const std::string& orders_path) {
  if (orders.empty()) return;
  if (!has_sibling("marco-map-pictures")) {
    std::fputs("no pictures: the viewer is not built (it needs EGL or OSMesa, and GL2PS)\n",
               stderr);
    return;
  }
  files::write_whole_file(orders_path, encode_picture_orders(std::move(orders)));
  const int code = run_sibling("marco-map-pictures", {orders_path});
  std::remove(orders_path.c_str());
  if (code != 0) throw std::runtime_error("marco-map-pictures could not draw the pictures");
}

}  // namespace marco
