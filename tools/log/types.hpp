#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/lcm_schema/decoder.hpp"
#include "common/lcm_schema/json.hpp"

namespace marco::logs {

/// The message types the log tools know: the built-in ones and those of the user's .lcm sources.
class Types {
 public:
  /// @param paths files or folders of .lcm sources; they hold before the built-in ones.
  /// @throws std::invalid_argument naming the first mistake in them.
  explicit Types(const std::vector<std::string>& paths);

  /// Index of the structure a message of this fingerprint is decoded as; -1 = not known. Of
  /// several that share it the latest.
  int structure_of(uint64_t fingerprint) const;

  /// "marco.pose2_t", or "" when the fingerprint is not known.
  std::string name_of(uint64_t fingerprint) const;

  /// Decodes a whole message. @returns the structure's index, or -1 when the type is not known or
  /// the bytes are no message of it.
  int decode(std::span<const uint8_t> message, lcm_schema::Tree& tree) const;

  /// Whether a message is whole, to its last byte; true for types that are not known.
  bool decodes(std::span<const uint8_t> message) const;

  const lcm_schema::Schema& schema() const { return schema_; }

 private:
  lcm_schema::Schema schema_;
  lcm_schema::Decoder decoder_;
};

}  // namespace marco::logs
