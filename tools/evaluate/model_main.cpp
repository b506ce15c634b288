#include <cstdio>

#include "common/files/mesh_file.hpp"
#include "common/files/tum.hpp"
#include "common/trajectory_fit.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "tools/evaluate/model_fit.hpp"
#include "tools/evaluate/model_judge.hpp"
#include "tools/evaluate/true_beams.hpp"

namespace marco {
namespace {

struct Arguments {
  std::string model, world, beams, trajectory;
  bool as_it_lies = false;
  bool list = false;
};

void print(const Pose3& pose) {
  const Eigen::Vector3d at = pose.translation(), up = pose.linear().col(2);
  const Pose2 flat = flatten(pose);
  std::printf("placed at x=%.4f y=%.4f z=%.4f m, heading %.3f deg, leaning %.3f deg\n", at.x(),
              at.y(), at.z(), rad_to_deg(flat.theta_rad),
              rad_to_deg(std::acos(std::min(1.0, up.z()))));
}

void print(const char* name, const Spread& spread) {
  std::printf("%s: n=%zu rms=%.4f median=%.4f p95=%.4f p99=%.4f max=%.4f m\n", name, spread.count,
              spread.rms_m, spread.median_m, spread.p95_m, spread.p99_m, spread.max_m);
}

Pose3 place(const Arguments& arguments,
            const TriangleMesh& model,
            const sim::RayCaster& world,
            const TrueBeams& beams) {
  if (arguments.as_it_lies) return Pose3::Identity();
  if (arguments.trajectory.empty()) return find_model(model, world).world_from_model;
  const TrajectoryFit path = fit_to_truth(files::read_tum(arguments.trajectory), beams.truth);
  require(path.count >= 2, arguments.trajectory + ": no pose has truth at its time");
  const Pose3 by_path = lift(path.truth_from_estimate);
  print("error, placed by the path", judge_model(moved(model, by_path), world, {}).error);
  return fit_model(model, world, by_path).world_from_model;
}

void list(const std::vector<SheetsApart>& all) {
  for (const SheetsApart& apart : all) {
    const Eigen::Vector3f &at = apart.place.point_m, &normal = apart.place.normal;
    std::printf("  at %.3f %.3f %.3f m, facing %.2f %.2f %.2f: sheets at %+.0f and %+.0f mm\n",
                static_cast<double>(at.x()), static_cast<double>(at.y()),
                static_cast<double>(at.z()), static_cast<double>(normal.x()),
                static_cast<double>(normal.y()), static_cast<double>(normal.z()),
                1e3 * static_cast<double>(apart.outer_m), 1e3 * static_cast<double>(apart.inner_m));
  }
}

int run(const Arguments& arguments) {
  const TriangleMesh model = files::read_mesh(arguments.model);
  require(!model.triangles.empty(), arguments.model + ": has no triangles");
  const sim::RayCaster world(
      sim::build_world(process::load_options<sim::WorldSpec>(arguments.world)));
  TrueBeams beams;
  if (!arguments.beams.empty()) beams = true_beams(arguments.beams, world);
  std::printf("%zu triangles, %zu vertices\n", model.triangles.size(), model.vertices_m.size());
  const Pose3 world_from_model = place(arguments, model, world, beams);
  print(world_from_model);
  const ModelJudgement found = judge_model(moved(model, world_from_model), world, beams.ends);
  print("error", found.error);
  if (found.coverage) {
    std::printf("coverage: %.2f %% of %zu places that beams hit have model within %.0f mm\n",
                100.0 * found.coverage->covered, found.coverage->places,
                1000.0 * found.coverage->near_m);
  }
  if (found.sheets) {
    const double places = static_cast<double>(std::max<std::size_t>(1, found.sheets->places));
    std::printf(
        "sheets of one true face: p99=%.4f max=%.4f m; double at %.3f %%, more than 20 mm "
        "apart at %.3f %% of %zu places\n",
        found.sheets->p99_m, found.sheets->max_m,
        100.0 * static_cast<double>(found.sheets->doubled) / places,
        100.0 * static_cast<double>(found.sheets->too_far) / places, found.sheets->places);
    if (arguments.list) list(found.sheets->apart);
  }
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco-evaluate-model", [&] {
    marco::process::CommandLine app(
        "Errors of a surface model against the simulated world: reads only the model and the "
        "world.\n"
        "  marco evaluate-model out/model.ply config/worlds/lab.toml --beams lab.lcm\n"
        "Every triangle is sampled, a point per 4 cm2. The model is aligned with the world by the "
        "best rigid motion.");
    marco::Arguments arguments;
    app.add_option("MODEL", arguments.model, "PLY or OBJ").required().existing_file();
    app.add_option("WORLD", arguments.world, "TOML, as config/worlds/lab.toml")
        .required()
        .existing_file();
    auto beams = app.add_option("--beams", arguments.beams,
                                "the simulated recording: reports the part of the surface seen by "
                                "its 3D sweeps that the model covers, and double sheets")
                     .existing_file();
    app.add_option("--trajectory", arguments.trajectory,
                   "the map's trajectory.tum: start from its fit to the truth; else search for the "
                   "pose of the model")
        .needs(beams)
        .existing_file();
    app.add_flag("--list", arguments.list,
                 "list the places where two sheets of one face are more than 20 mm apart")
        .needs(beams);
    app.add_flag("--as-it-lies", arguments.as_it_lies,
                 "do not align: the model is already in the world's frame");
    if (const auto code = app.parse(argc, argv)) return *code;
    return marco::run(arguments);
  });
}
