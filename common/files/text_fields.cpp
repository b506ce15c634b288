#include "common/files/text_fields.hpp"

#include <cmath>
#include <sstream>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {

std::vector<NumericRow> read_numeric_rows(const std::string& path) {
  std::istringstream file(read_whole_file(path));
  std::vector<NumericRow> rows;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    NumericRow row{path + ":" + std::to_string(number), {}};
    TextFields fields(std::string_view(line).substr(0, line.find('#')));
    for (std::string_view field = fields.next(); !field.empty(); field = fields.next()) {
      const auto value = TextFields(field).number<double>();
      require(value && std::isfinite(*value),
              row.place + ": '" + std::string(field.substr(0, 40)) + "' is not a finite number");
      row.numbers.push_back(*value);
    }
    if (!row.numbers.empty()) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace marco::files
