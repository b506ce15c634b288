#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "common/files/map_yaml.hpp"
#include "common/files/relations.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/process/config.hpp"
#include "python/arrays.hpp"
#include "tools/map/judged_map.hpp"
#include "tools/map/map_arguments.hpp"
#include "tools/map/scratch_folder.hpp"

namespace py = pybind11;

namespace marco::python {
namespace {

struct Map {
  Trajectory trajectory;
  Trajectory live;
  Trajectory odometry;
  GridMap grid;
  std::size_t loops = 0;
  std::string verdict;
  std::vector<std::string> reasons;

  /// Rows from low to high y, as pyplot.imshow(..., origin="lower") takes them.
  py::array_t<uint8_t> cells() const {
    return py::array_t<uint8_t>({grid.height_cells, grid.width_cells}, grid.occupancy.data());
  }
  void save(const std::filesystem::path& folder) const {
    std::filesystem::create_directories(folder);
    files::write_map(folder, grid);
    files::write_tum(folder / "trajectory.tum", trajectory);
  }
};

Map make(const std::vector<std::string>& inputs, const std::string& config, bool lines) {
  const py::gil_scoped_release released;
  MapArguments arguments;
  arguments.inputs = inputs;
  arguments.config = config;
  arguments.lines = lines;
  const ScratchFolder folder;
  const JudgedMap made =
      make_corrected_map(arguments, load_batch_input(arguments), folder.path()).map;
  const MapJob& job = *made.job;
  Map map{job.trajectory(),
          job.live_trajectory(),
          job.odometry_trajectory(),
          job.grid(),
          job.loops().size(),
          {},
          {}};
  if (made.verdict) {
    map.verdict = slam::to_string(made.verdict->diagnosis.verdict);
    map.reasons = made.verdict->diagnosis.open_questions;
    for (const slam::Reason& reason : made.verdict->diagnosis.reasons) {
      map.reasons.push_back(reason.why);
    }
  }
  return map;
}

Trajectory to_trajectory(const py::array_t<double, py::array::forcecast>& poses) {
  if (poses.ndim() != 2 || poses.shape(1) != 4) {
    throw std::invalid_argument("poses are rows of seconds, x, y and heading");
  }
  const auto rows = poses.unchecked<2>();
  Trajectory trajectory;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    trajectory.push_back(
        {Utime::from_us(std::llround(1e6 * rows(i, 0))), {rows(i, 1), rows(i, 2), rows(i, 3)}});
  }
  return trajectory;
}

py::dict to_dict(const RelationsError& error) {
  py::dict result;
  result["n"] = error.count;
  result["mean_m"] = error.translation_m.mean;
  result["max_m"] = error.translation_m.max;
  result["mean_deg"] = error.rotation_deg.mean;
  result["max_deg"] = error.rotation_deg.max;
  return result;
}

}  // namespace

void bind_map(py::module_& module) {
  py::class_<Map>(module, "Map")
      .def_property_readonly("trajectory", [](const Map& map) { return to_array(map.trajectory); })
      .def_property_readonly("live_trajectory", [](const Map& map) { return to_array(map.live); })
      .def_property_readonly("odometry", [](const Map& map) { return to_array(map.odometry); })
      .def_property_readonly("grid", &Map::cells)
      .def_property_readonly("resolution", [](const Map& map) { return map.grid.resolution_m; })
      .def_property_readonly(
          "origin",
          [](const Map& map) { return std::pair(map.grid.origin_m.x(), map.grid.origin_m.y()); })
      .def_readonly("loops", &Map::loops)
      .def_readonly("verdict", &Map::verdict)
      .def_readonly("reasons", &Map::reasons)
      .def("save", &Map::save, py::arg("folder"));
  module.def("_map", &make, py::arg("inputs"), py::arg("config"), py::arg("lines"));
  module.def("_evaluate", [](const py::array_t<double, py::array::forcecast>& poses,
                             const std::string& path) {
    const auto report = compare_with_relations(to_trajectory(poses), files::read_relations(path));
    py::dict result = to_dict(report.all);
    result["skipped"] = report.skipped;
    result["far_apart"] = to_dict(report.far_apart);
    return result;
  });
  module.def("_settings", [] { return process::print_options(MapOptions{}); });
}

}  // namespace marco::python
