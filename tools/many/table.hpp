#pragma once

#include <string>
#include <vector>

#include "tools/many/job.hpp"

namespace marco::many {

/// The result of one recording.
struct Row {
  std::string name;
  std::string path;
  std::string format;
  int64_t scans = 0;
  double length_m = 0.0;
  int64_t loops = 0;    ///< in force
  std::string verdict;  ///< good, doubtful, wrong, failed, or "not done"
  std::string reason;   ///< why it failed
  double cpu_s = 0.0;
  bool has_picture = false;
};

/// From its report.json, or the record of its failure.
Row row_of(const Store& store, const Entry& entry);

/// log, format, scans, length_m, loops, verdict, cpu_s, picture, reason; RFC 4180.
std::string csv_of(const std::vector<Row>& rows);
/// The same as a page, with pictures; its links are relative to the folder of all results.
std::string html_of(const std::vector<Row>& rows);

/// Writes table.csv and index.html. @returns the rows
std::vector<Row> write_table(const Store& store, const std::vector<Entry>& entries);

}  // namespace marco::many
