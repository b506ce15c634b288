#include "python/arrays.hpp"

// The words of help() are in marco/__init__.pyi, where editors and type checkers read them.
PYBIND11_MODULE(_marco, module) {
  marco::python::bind_scan(module);
  marco::python::bind_read(module);
  marco::python::bind_map(module);
  marco::python::bind_live(module);
}
