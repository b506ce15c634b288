#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace marco {

/// A file of numbers with a line of column names, separated by commas; plain or gzip.
struct CsvTable {
  std::filesystem::path path;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;

  std::optional<std::size_t> find(const std::string& column) const;
  /// @throws std::invalid_argument naming the file and its columns where there is none of it
  std::size_t index_of(const std::string& column) const;
};

/// @throws std::invalid_argument naming file and line where a row has another number of fields than
/// the head, or a field that is no finite number; or where the file cannot be read, is damaged or
/// unpacks to more than 1 GB.
CsvTable read_csv(const std::filesystem::path& path);

/// NAME.csv or NAME.csv.gz in a folder. @returns nothing where neither is there
std::optional<std::filesystem::path> find_csv(const std::filesystem::path& folder,
                                              const std::string& name);

}  // namespace marco
