#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lcm_tools/schema/decoder.hpp"
#include "lcm_tools/schema/json.hpp"

namespace marco::logs {

/// The message types the log tools know: the built-in ones and those of the user's .lcm sources.
class Types {
 public:
  /// @param paths files or folders of .lcm sources; they hold before the built-in ones. What is
  /// wrong in them is in problems(), the rest is used.
  /// @throws std::invalid_argument naming the first path where there is nothing.
  explicit Types(const std::vector<std::string>& paths);

  /// What could not be used of the sources, a line for a person each.
  const std::vector<std::string>& problems() const { return problems_; }

  /// Index of the structure a message of this fingerprint is decoded as; -1 = not known. Of
  /// several that share it the latest.
  int structure_of(uint64_t fingerprint) const;

  /// "marco.pose2_t", or "" when the fingerprint is not known.
  std::string name_of(uint64_t fingerprint) const;

  /// Decodes a whole message. @returns the structure's index, or -1 when the type is not known or
  /// the bytes are not a message of it.
  int decode(std::span<const uint8_t> message, lcm_schema::Tree& tree) const;

  /// Whether a message is whole, to its last byte; true for types that are not known.
  bool decodes(std::span<const uint8_t> message) const;

  const lcm_schema::Schema& schema() const { return schema_; }

 private:
  std::vector<std::string> problems_;
  lcm_schema::Schema schema_;
  lcm_schema::Decoder decoder_;
};

/// Prints types.problems() on stderr.
void print_problems(const Types& types);

}  // namespace marco::logs
