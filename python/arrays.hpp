#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "common/trajectory.hpp"

namespace marco::python {

/// N x `columns` numbers, filled by `row(i, numbers)`.
template <class Row>
pybind11::array_t<double> table(std::size_t rows, std::size_t columns, Row&& row) {
  pybind11::array_t<double> array({rows, columns});
  double* numbers = array.mutable_data();
  for (std::size_t i = 0; i < rows; ++i) row(i, numbers + i * columns);
  return array;
}

inline double seconds_of(Utime utime) { return 1e-6 * static_cast<double>(utime.us); }

/// N x 4: seconds since 1970, x [m], y [m], heading [rad].
inline pybind11::array_t<double> to_array(const Trajectory& trajectory) {
  return table(trajectory.size(), 4, [&](std::size_t i, double* row) {
    const Pose2& pose = trajectory[i].world_from_robot;
    row[0] = seconds_of(trajectory[i].utime);
    row[1] = pose.x_m;
    row[2] = pose.y_m;
    row[3] = pose.theta_rad;
  });
}

void bind_scan(pybind11::module_& module);
void bind_read(pybind11::module_& module);
void bind_map(pybind11::module_& module);
void bind_live(pybind11::module_& module);

}  // namespace marco::python
