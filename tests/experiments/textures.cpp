// Seams of textured models, with known faults of the pictures. FOLDER is of `marco demo`.
//   textures plant FOLDER OUT SEED          photographs of other exposures (20 %) and white balance
//                                           (10 %), every fourth with a person 2 m ahead: OUT
//   textures judge FOLDER GLB WORLD TOUR    contrast of the model's seams
//   textures gains FOLDER PLANTED SEED      how well paint() finds the planted gains
// `marco texture FOLDER/model.ply OUT/photographs.toml --out GLB` paints with what was planted.
// Seam contrast: of two texels of one triangle, 10 cm on either side of where the best view
// changes, the step of the colour (its largest channel, grey levels of 255), less the step of the
// world's own colours there; places without any step of the world's. Beside it the same 20 cm apart
// within one view: what the light itself changes.
#include <cmath>
#include <cstdio>
#include <random>

#include "common/files/glb.hpp"
#include "common/files/ply.hpp"
#include "common/textured_mesh.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/config.hpp"
#include "mapping3d/surface/surface_looks.hpp"
#include "mapping3d/surface/texture_raster.hpp"
#include "simulator/camera_view.hpp"
#include "simulator/tour.hpp"
#include "tools/texture/load_photograph.hpp"
#include "viewer/image_io.hpp"

namespace marco {
namespace {

using mapping3d::CameraPicture;

PhotographList list_of(const std::filesystem::path& folder) {
  return process::load_options<PhotographList>((folder / "photographs.toml").string());
}

std::vector<CameraPicture> pictures_of(const std::filesystem::path& folder) {
  std::vector<CameraPicture> pictures;
  for (const PhotographSpec& spec : list_of(folder).photographs) {
    pictures.push_back(load(spec, folder));
  }
  return pictures;
}

std::vector<Eigen::Vector3f> planted_gains(std::size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> exposure(-0.2F, 0.2F), balance(-0.1F, 0.1F);
  std::vector<Eigen::Vector3f> gains;
  for (std::size_t i = 0; i < count; ++i) {
    const float all = 1.0F + exposure(random);
    gains.emplace_back(all * (1.0F + balance(random)), all, all * (1.0F + balance(random)));
  }
  return gains;
}

// Red trousers, dark green above, half a metre wide, without anything of theirs in the model.
struct Person {
  Eigen::Vector3f feet_m;
  Eigen::Vector3f across;

  std::optional<std::pair<float, Eigen::Vector3f>> meet(const Eigen::Vector3f& from_m,
                                                        const Eigen::Vector3f& way) const {
    const Eigen::Vector3f normal = across.cross(Eigen::Vector3f::UnitZ());
    const float range_m = normal.dot(feet_m - from_m) / normal.dot(way);
    const Eigen::Vector3f at = from_m + range_m * way - feet_m;
    const bool met =
        range_m > 0.0F && std::abs(across.dot(at)) < 0.25F && at.z() > 0.0F && at.z() < 1.75F;
    if (!met) return std::nullopt;
    return std::pair(range_m,
                     at.z() < 0.9F ? Eigen::Vector3f(150, 30, 35) : Eigen::Vector3f(25, 60, 40));
  }
};

Person person_ahead(const CameraPicture& picture, float aside_m) {
  const Eigen::Matrix3f turn = picture.world_from_camera.linear().cast<float>();
  Eigen::Vector3f feet_m = picture.world_from_camera.translation().cast<float>() +
                           2.0F * turn.col(2) + aside_m * turn.col(0);
  feet_m.z() = 0.0F;
  return {feet_m, turn.col(0)};
}

sim::World world_of(const TriangleMesh& mesh) {
  sim::World world;
  world.vertices_m = mesh.vertices_m;
  world.triangles = mesh.triangles;
  world.materials.resize(mesh.triangles.size(), sim::Material::plain);
  return world;
}

void stand_in(const Person& person, const sim::RayCaster& rays, CameraPicture& picture) {
  const mapping3d::CameraModel& camera = picture.camera;
  const Eigen::Vector3f from_m = picture.world_from_camera.translation().cast<float>();
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const Eigen::Vector3d ray((x - camera.centre_x_px) / camera.focal_x_px,
                                (y - camera.centre_y_px) / camera.focal_y_px, 1.0);
      const Eigen::Vector3f way =
          (picture.world_from_camera.linear() * ray).normalized().cast<float>();
      const auto met = person.meet(from_m, way);
      if (!met || rays.cast(from_m, way, met->first)) continue;
      uint8_t* rgb = &picture.rgb[3 * mapping3d::pixel_at(x, y, camera.width_px)];
      for (int i = 0; i < 3; ++i) rgb[i] = static_cast<uint8_t>(met->second[i]);
    }
  }
}

void plant(const std::filesystem::path& folder, const std::filesystem::path& out, uint32_t seed) {
  PhotographList list = list_of(folder);
  const auto gains = planted_gains(list.photographs.size(), seed);
  const sim::RayCaster rays(world_of(files::read_ply((folder / "model.ply").string())));
  std::filesystem::create_directories(out);
  std::mt19937 random(seed + 1);
  std::uniform_real_distribution<float> aside_m(-0.8F, 0.8F);
  for (std::size_t k = 0; k < gains.size(); ++k) {
    CameraPicture picture = load(list.photographs[k], folder);
    if (k % 4 == 1) stand_in(person_ahead(picture, aside_m(random)), rays, picture);
    viewer::Picture planted(picture.camera.width_px, picture.camera.height_px, {});
    for (std::size_t i = 0; i < planted.pixels.size(); ++i) {
      std::array<uint8_t, 3> rgb{};
      for (std::size_t c = 0; c < 3; ++c) {
        const float value = gains[k][static_cast<int>(c)] * picture.rgb[3 * i + c];
        rgb[c] = static_cast<uint8_t>(std::lround(std::min(255.0F, value)));
      }
      planted.pixels[i] = {rgb[0], rgb[1], rgb[2]};
    }
    list.photographs[k].file = std::to_string(k) + ".png";
    viewer::write_png(planted, (out / list.photographs[k].file).string());
  }
  files::write_whole_file(out / "photographs.toml", process::print_options(list));
}

// The world's own colours, for points of the map.
class Truth {
 public:
  Truth(const std::string& world, const std::string& tour)
      : rays_(sim::build_world(process::load_options<sim::WorldSpec>(world))) {
    const auto start = process::load_options<sim::Tour>(tour);
    world_from_map_.linear() =
        Eigen::AngleAxisf(static_cast<float>(deg_to_rad(start.start_heading_deg)),
                          Eigen::Vector3f::UnitZ())
            .toRotationMatrix();
    world_from_map_.translation() =
        Eigen::Vector3d(start.start_m[0], start.start_m[1], 0.0).cast<float>();
  }

  // From in front of the surface. Nothing where the world has no such surface within 10 cm.
  std::optional<Eigen::Vector3f> colour(const Eigen::Vector3f& point_m,
                                        const Eigen::Vector3f& normal) const {
    const Eigen::Vector3f out = world_from_map_.linear() * normal;
    const auto hit = rays_.cast(world_from_map_ * point_m + 0.1F * out, -out, 0.2F);
    if (!hit || hit->normal.dot(out) < 0.9F || hit->material == sim::Material::glass) {
      return std::nullopt;
    }
    return sim::colour_of(hit->normal, hit->material);
  }

 private:
  sim::RayCaster rays_;
  Eigen::Isometry3f world_from_map_ = Eigen::Isometry3f::Identity();
};

struct Texel {
  int triangle = -1;
  int view = -1;
  Eigen::Vector3f point_m;
};

std::vector<Texel> best_views(const TexturedMesh& model,
                              const std::vector<mapping3d::TextureView>& views,
                              int width,
                              int height) {
  std::vector<Texel> texels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::vector<const mapping3d::TextureView*> chosen;
  std::vector<mapping3d::Look> looks;
  for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
    const auto& triangle = model.mesh.triangles[t];
    const mapping3d::Facet facet(model.mesh, triangle);
    mapping3d::choose_views(views, facet, chosen);
    std::array<Eigen::Vector2f, 3> places;
    for (std::size_t i = 0; i < 3; ++i) {
      places[i] = model.uvs[triangle[i]].cwiseProduct(
                      Eigen::Vector2f(static_cast<float>(width), static_cast<float>(height))) -
                  Eigen::Vector2f::Constant(0.5F);
    }
    mapping3d::for_each_pixel(
        places, width, height, 0.0F, [&](int x, int y, const Eigen::Vector3f& w) {
          Texel& texel = texels[mapping3d::pixel_at(x, y, width)];
          texel.triangle = static_cast<int>(t);
          texel.point_m =
              w[0] * facet.corners_m[0] + w[1] * facet.corners_m[1] + w[2] * facet.corners_m[2];
          mapping3d::look_from_all(chosen, texel.point_m, facet.normal, looks);
          float most = 0.0F;
          for (const auto& look : looks) {
            if (look.merit <= most) continue;
            most = look.merit;
            texel.view = static_cast<int>(look.view);
          }
        });
  }
  return texels;
}

void print(const char* name, std::vector<float>& steps, const char* unit) {
  std::sort(steps.begin(), steps.end());
  double sum = 0.0;
  for (const float step : steps) sum += static_cast<double>(step);
  const auto at = [&](double part) {
    return static_cast<double>(
        steps[static_cast<std::size_t>(part * static_cast<double>(steps.size() - 1))]);
  };
  std::printf("%-22s %7zu places: mean %5.2f, median %5.2f, p90 %5.2f, p99 %5.2f %s\n", name,
              steps.size(), sum / static_cast<double>(steps.size()), at(0.5), at(0.9), at(0.99),
              unit);
}

void judge(const std::filesystem::path& folder, const std::string& glb, const Truth& truth) {
  constexpr float kApartM = 0.2F;
  const TexturedMesh model = files::read_glb(glb);
  const viewer::Picture atlas = viewer::decode_picture(model.image);
  const std::vector<CameraPicture> pictures = pictures_of(folder);
  std::vector<mapping3d::TextureView> views;
  for (const CameraPicture& picture : pictures) {
    views.emplace_back(picture, model.mesh, mapping3d::TextureOptions{},
                       static_cast<uint32_t>(views.size()));
  }
  const auto texels = best_views(model, views, atlas.width_px, atlas.height_px);
  std::vector<float> seams, within, next;
  const auto step_of = [&](int x, int y, int apart, bool right) {
    const int dx = right ? apart : 0, dy = right ? 0 : apart;
    if (x + dx >= atlas.width_px || y + dy >= atlas.height_px) return;
    const std::size_t at = mapping3d::pixel_at(x, y, atlas.width_px);
    const std::size_t there = mapping3d::pixel_at(x + dx, y + dy, atlas.width_px);
    const Texel &a = texels[at], &b = texels[there];
    if (a.triangle < 0 || a.triangle != b.triangle || a.view < 0 || b.view < 0) return;
    if (apart > 1) {  // the seam in the middle
      const std::size_t mid = mapping3d::pixel_at(x + dx / 2, y + dy / 2, atlas.width_px);
      const std::size_t past = mapping3d::pixel_at(x + dx / 2 + (right ? 1 : 0),
                                                   y + dy / 2 + (right ? 0 : 1), atlas.width_px);
      if (a.view != b.view && (texels[mid].view != a.view || texels[past].view != b.view)) return;
    }
    const mapping3d::Facet facet(model.mesh,
                                 model.mesh.triangles[static_cast<std::size_t>(a.triangle)]);
    const auto here = truth.colour(a.point_m, facet.normal);
    const auto other = truth.colour(b.point_m, facet.normal);
    if (!here || !other || (*here - *other).cwiseAbs().maxCoeff() > 0.5F) return;
    const viewer::Rgb &p = atlas.pixels[at], &q = atlas.pixels[there];
    const int step =
        std::max({std::abs(p.red - q.red), std::abs(p.green - q.green), std::abs(p.blue - q.blue)});
    if (apart == 1) {
      if (a.view != b.view) next.push_back(static_cast<float>(step));
    } else {
      (a.view != b.view ? seams : within).push_back(static_cast<float>(step));
    }
  };
  const Texel* first = nullptr;
  float texel_m = 0.02F;
  for (const Texel& texel : texels) {  // two in a row tell the size of a texel
    if (first != nullptr && texel.triangle >= 0 && texel.triangle == first->triangle) {
      texel_m = std::min(texel_m * 5.0F, (texel.point_m - first->point_m).norm());
      break;
    }
    first = &texel;
  }
  const int apart = 2 * std::max(1, static_cast<int>(std::lround(0.5F * kApartM / texel_m)));
  for (int y = 0; y < atlas.height_px; ++y) {
    for (int x = 0; x < atlas.width_px; ++x) {
      for (const bool right : {true, false}) {
        step_of(x, y, 1, right);
        step_of(x, y, apart, right);
      }
    }
  }
  print("seams, next texels", next, "levels");
  print("seams, 20 cm apart", seams, "levels");
  print("one view, 20 cm apart", within, "levels");
}

void compare_gains(const std::filesystem::path& folder,
                   const std::filesystem::path& planted,
                   uint32_t seed) {
  const TriangleMesh model = files::read_glb(folder / "model_textured.glb").mesh;
  const auto before = mapping3d::paint(model, pictures_of(folder)).gains;
  const auto after = mapping3d::paint(model, pictures_of(planted)).gains;
  const auto truth = planted_gains(before.size(), seed);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> off;
  std::vector<float> sizes, invented;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    off.emplace_back(
        (after[i].array() * truth[i].array() / before[i].array()).log().cast<double>());
    mean += off.back() / static_cast<double>(truth.size());
  }
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      sizes.push_back(static_cast<float>(100.0 * std::abs(off[i][c] - mean[c])));
      invented.push_back(100.0F * std::abs(std::log(before[i][c])));
    }
  }
  print("planted gains, off", sizes, "%");
  print("found without any", invented, "%");
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  const std::string what = argv[1];
  if (what == "plant") {
    marco::plant(argv[2], argv[3], static_cast<uint32_t>(std::stoul(argv[4])));
  } else if (what == "judge" && argc == 6) {
    marco::judge(argv[2], argv[3], marco::Truth(argv[4], argv[5]));
  } else if (what == "gains") {
    marco::compare_gains(argv[2], argv[3], static_cast<uint32_t>(std::stoul(argv[4])));
  } else {
    return 2;
  }
  return 0;
}
