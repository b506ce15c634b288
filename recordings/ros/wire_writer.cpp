#include "recordings/ros/wire_writer.hpp"

#include <bit>
#include <string>

#include "lcm_tools/base/check.hpp"

namespace marco::ros {

static_assert(std::endian::native == std::endian::little);

WireWriter::WireWriter(std::string_view encoding) {
  require(encoding == "ros1" || encoding == "cdr",
          "messages are written as ros1 or cdr, not as " + std::string(encoding));
  if (encoding == "cdr") bytes_ = {0x00, 0x01, 0x00, 0x00};
  header_bytes_ = bytes_.size();
}

// CDR counts and writes a NUL at the end.
void WireWriter::string(std::string_view text) {
  count(text.size() + (is_cdr() ? 1 : 0));
  bytes_.insert(bytes_.end(), text.begin(), text.end());
  if (is_cdr()) bytes_.push_back(0);
}

void WireWriter::time(int64_t ns) {
  constexpr int64_t kSecondNs = 1'000'000'000;
  const int64_t shown_ns = std::max<int64_t>(0, ns);
  number(static_cast<uint32_t>(shown_ns / kSecondNs));
  number(static_cast<uint32_t>(shown_ns % kSecondNs));
}

// ROS 1 counts headers before the stamp; recorded ones are mostly 0.
void WireWriter::header(int64_t stamp_ns, std::string_view frame) {
  if (!is_cdr()) number<uint32_t>(0);
  time(stamp_ns);
  string(frame);
}

}  // namespace marco::ros
