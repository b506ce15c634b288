#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "common/files/text_fields.hpp"
#include "recordings/sample_reader.hpp"

namespace marco::files {

/// Base of the readers of text logs with one record a line. A subclass reads the file twice:
/// survey() finds which range means "no return" before the first sample.
class TextReader : public QueuedReader {
 public:
  double progress() const final;

 protected:
  TextReader(const std::filesystem::path& path, const char* format);

  /// The whole file from its start, line by line; then it is rewound.
  void survey(const std::function<void(TextFields)>& use_line);

  virtual void read_line(TextFields fields) = 0;
  bool read_piece() final;

  /// Counts a line that cannot be used, with its number.
  void drop_line(const char* cause) { report_.drop(cause, "line " + std::to_string(line_number_)); }
  void note_no_return(double range_m);

 private:
  bool next_line();

  std::string path_;
  std::ifstream file_;
  std::string text_;
  double size_bytes_ = 0.0;
  double read_bytes_ = 0.0;
  int64_t line_number_ = 0;
};

/// Fields `n r1 .. rn`. @returns false, with `ranges_m` spoilt, where they cannot be read.
bool read_ranges(TextFields& fields, std::vector<float>& ranges_m);

/// Fields `x y theta` [m, rad] as they are, also nan; nothing where one of them is no number.
std::optional<Pose2> read_pose(TextFields& fields);

}  // namespace marco::files
