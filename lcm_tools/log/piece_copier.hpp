#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "lcm_tools/log/output_file.hpp"

namespace marco::logs {

/// Copies stretches of a file, joining those that lie next to each other, so that few large pieces
/// are copied. Both must outlive it; copy() at the end.
class PieceCopier {
 public:
  /// @throws std::invalid_argument naming the path when it cannot be read.
  PieceCopier(const std::filesystem::path& in, OutputFile& out);
  ~PieceCopier();
  PieceCopier(const PieceCopier&) = delete;
  PieceCopier& operator=(const PieceCopier&) = delete;

  /// Bytes [from, to) come next.
  void add(int64_t from, int64_t to);
  /// Brings out what was added so far.
  void copy();

 private:
  void copy_small();

  int source_;
  OutputFile& out_;
  int64_t from_ = 0;
  int64_t to_ = 0;
  std::vector<uint8_t> window_;
  int64_t window_start_ = 0;
};

}  // namespace marco::logs
