#include "python/scan.hpp"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <limits>

#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/surfel_matcher.hpp"

namespace py = pybind11;

namespace marco::python {
namespace {

constexpr double kSearchM = 1.0;
constexpr double kSearchDeg = 30.0;

struct Match {
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double overlap = 0.0;
  bool converged = false;
};

using Rows2 = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

// An exhaustive search within 1 m and 30 degrees of the guess, then the fine match.
Match match(const Rows2& target, const Rows2& source, const std::array<double, 3>& guess) {
  const Points2 walls = target.transpose();
  const Points2 points = source.transpose();
  const py::gil_scoped_release released;
  const slam::CorrelativeMatcher exhaustive;
  const slam::SearchWindow window{Pose2{guess[0], guess[1], guess[2]}, kSearchM,
                                  deg_to_rad(kSearchDeg)};
  const slam::CorrelativeMatch coarse =
      exhaustive.search(slam::LikelihoodPyramid(walls, exhaustive.options()), points, window, 0.0);
  const slam::SurfelMatcher matcher;
  slam::SurfelPyramid map(matcher.options(), {0.0, 0.0});
  map.add(slam::orient(walls, {0.0, 0.0}, {}), {});
  const slam::SurfelMatch fine =
      matcher.match(map, slam::orient(points, {0.0, 0.0}, {}), coarse.map_from_robot, nullptr);
  return {fine.map_from_robot.vector(), fine.information, fine.overlap,
          fine.status == slam::SurfelMatch::Status::converged};
}

}  // namespace

py::array_t<double> Scan::points() const {
  const auto ranges = ranges_m.unchecked<1>();
  const auto bearings = bearings_rad.unchecked<1>();
  std::vector<double> numbers;
  for (py::ssize_t i = 0; i < ranges.size(); ++i) {
    if (std::isnan(ranges(i))) continue;
    numbers.push_back(static_cast<double>(ranges(i)) * std::cos(bearings(i)));
    numbers.push_back(static_cast<double>(ranges(i)) * std::sin(bearings(i)));
  }
  return py::array_t<double>({numbers.size() / 2, std::size_t{2}}, numbers.data());
}

Scan to_scan(const LaserScan& scan, double range_min_m, double range_max_m) {
  Scan result{seconds_of(scan.utime), scan.channel,
              py::array_t<float>(static_cast<py::ssize_t>(scan.size())),
              py::array_t<double>(static_cast<py::ssize_t>(scan.size()))};
  float* ranges = result.ranges_m.mutable_data();
  double* bearings = result.bearings_rad.mutable_data();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double range = static_cast<double>(scan.ranges_m[i]);
    const bool returned = range > range_min_m && range < range_max_m;
    ranges[i] = returned ? scan.ranges_m[i] : std::numeric_limits<float>::quiet_NaN();
    bearings[i] = scan.bearing_rad(i);
  }
  return result;
}

void bind_scan(py::module_& module) {
  py::class_<Scan>(module, "Scan")
      .def_readonly("time", &Scan::time_s)
      .def_readonly("channel", &Scan::channel)
      .def_readonly("ranges", &Scan::ranges_m)
      .def_readonly("bearings", &Scan::bearings_rad)
      .def("points", &Scan::points)
      .def("__len__", [](const Scan& scan) { return scan.ranges_m.size(); });
  py::class_<Match>(module, "Match")
      .def_readonly("pose", &Match::pose)
      .def_readonly("information", &Match::information)
      .def_readonly("overlap", &Match::overlap)
      .def_readonly("converged", &Match::converged);
  module.def("match", &match, py::arg("target"), py::arg("source"),
             py::arg("guess") = std::array{0.0, 0.0, 0.0});
}

}  // namespace marco::python
