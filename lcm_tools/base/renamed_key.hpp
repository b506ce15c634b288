#pragma once

#include <string_view>

namespace marco {

/// A key of an earlier release: refused, with the name it has now. An options struct may list them
/// as `static constexpr std::array kRenamed{RenamedKey{"before", "now"}, ...}`.
struct RenamedKey {
  std::string_view before;
  std::string_view now;
};

}  // namespace marco
