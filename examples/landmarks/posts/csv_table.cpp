#include "posts/csv_table.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <sstream>

#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"

namespace marco {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 30;

std::string unpack(const std::filesystem::path& path) {
  files::require_readable(path);
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
  require(file != nullptr, path.string() + ": cannot be read");
  std::string text;
  std::array<char, 1 << 16> bytes{};
  int count = 0;
  while ((count = gzread(file.get(), bytes.data(), bytes.size())) > 0) {
    text.append(bytes.data(), static_cast<std::size_t>(count));
    require(text.size() <= kMostBytes, path.string() + ": decompresses to more than 1 GB");
  }
  int fault = Z_OK;
  gzerror(file.get(), &fault);
  // A packed file that ends early is a fault only when it is read to its end.
  require(count == 0 && (fault == Z_OK || fault == Z_STREAM_END), path.string() + ": is damaged");
  return text;
}

}  // namespace

std::optional<std::size_t> CsvTable::find(const std::string& column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

std::size_t CsvTable::index_of(const std::string& column) const {
  const auto found = find(column);
  if (found) return *found;
  std::string names;
  for (const std::string& name : columns) names += (names.empty() ? "" : ", ") + name;
  throw std::invalid_argument(path.string() + ": has no column " + column + ", but " +
                              (names.empty() ? "none" : names));
}

CsvTable read_csv(const std::filesystem::path& path) {
  CsvTable table;
  table.path = path;
  std::istringstream file(unpack(path));
  std::string line;
  for (int number = 1; files::read_line(file, line); ++number) {
    files::TextFields fields(line);
    std::vector<double> row;
    if (table.columns.empty()) {
      for (auto name = fields.next(); !name.empty(); name = fields.next()) {
        table.columns.emplace_back(name);
      }
      continue;
    }
    for (auto field = fields.next(); !field.empty(); field = fields.next()) {
      const auto value = files::TextFields(field).number<double>();
      require(value && std::isfinite(*value), path.string() + ":" + std::to_string(number) + ": '" +
                                                  std::string(field.substr(0, 40)) +
                                                  "' is not a finite number");
      row.push_back(*value);
    }
    if (row.empty()) continue;
    require(row.size() == table.columns.size(),
            path.string() + ":" + std::to_string(number) + ": has " + std::to_string(row.size()) +
                " fields, the header " + std::to_string(table.columns.size()));
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::optional<std::filesystem::path> find_csv(const std::filesystem::path& folder,
                                              const std::string& name) {
  for (const char* ending : {".csv", ".csv.gz"}) {
    const std::filesystem::path path = folder / (name + ending);
    if (std::filesystem::exists(path)) return path;
  }
  return std::nullopt;
}

}  // namespace marco
