#include "common/files/relations.hpp"

#include <sstream>

#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {

std::vector<PoseRelation> read_relations(const std::string& path) {
  std::istringstream file(read_whole_file(path));
  std::vector<PoseRelation> relations;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::string place = path + ":" + std::to_string(number);
    const std::vector<double> row = finite_numbers(line, place);
    if (row.empty()) continue;
    require(row.size() >= 8, place + ": expected 'time1 time2 x y z roll pitch yaw'");
    relations.push_back({row[0], row[1], {row[2], row[3], row[7]}});
  }
  return relations;
}

}  // namespace marco::files
