#pragma once

namespace marco::process {

/// Which settings of a configuration are printed.
enum class Printed {
  all,
  common,  ///< without the advanced ones that have their default
  changed  ///< those that differ from their default
};

}  // namespace marco::process
