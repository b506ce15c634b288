#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "recordings/ros/byte_file.hpp"

namespace marco::ros {

/// A row of a recording's table of messages.
struct Db3Row {
  int64_t id = 0, topic = 0, time_ns = 0;
  std::vector<uint8_t> data;
};

/// The messages of a database that sqlite cannot read any more, page by page, without the trees
/// that lead to them (sqlite.org/fileformat2.html, sections 1.3, 1.6 and 2.1): as the recorder
/// wrote them, in nearly the order of their times. Memory: one message.
class Db3Pages {
 public:
  explicit Db3Pages(const std::filesystem::path& path);

  std::optional<Db3Row> next();
  /// The part of the file that its header promises and that is not there.
  int64_t missing_bytes() const;

 private:
  bool next_page();
  std::optional<Db3Row> row_at(std::size_t at);
  bool append_overflow(uint64_t page, uint64_t size, std::vector<uint8_t>& payload);

  ByteFile file_;
  int64_t page_bytes_ = 0, usable_bytes_ = 0, pages_told_ = 0;
  int64_t page_ = 1;  // of which the cells are taken, from 1
  std::vector<uint8_t> bytes_;
  std::size_t cell_ = 0, cells_ = 0;
  int64_t overflow_pages_ = 0;  // that were read
};

}  // namespace marco::ros
