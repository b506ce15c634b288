#include "common/files/relations.hpp"

#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::files {

std::vector<PoseRelation> read_relations(const std::string& path) {
  std::vector<PoseRelation> relations;
  for (const auto& [place, row] : read_numeric_rows(path)) {
    require(row.size() >= 8, place + ": expected 'time1 time2 x y z roll pitch yaw'");
    relations.push_back({row[0], row[1], {row[2], row[3], row[7]}});
  }
  return relations;
}

}  // namespace marco::files
