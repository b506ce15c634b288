#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lcm_tools/schema/schema.hpp"
#include "lcm_tools/schema/tree.hpp"

namespace marco::lcm_schema {

enum class DecodeStatus : uint8_t {
  ok,
  wrong_fingerprint,  ///< the message is of another type (or shorter than a fingerprint)
  truncated,          ///< it ends before its last field
  bad_length,         ///< a negative array length, or a string's length below 1
  too_deep,           ///< structs nested deeper than 64
  too_large           ///< more than a million nodes, or more than 1 GB
};
const char* name_of(DecodeStatus status);

/// Decodes messages of any type of a schema along plans compiled once. No message can make it read
/// outside its bytes, recurse without bound or allocate more than 80 MB. It accepts what lcm-gen's
/// decoders accept (bytes behind the last field included). The schema must outlive it. Const: safe
/// from several threads, each with its own Tree.
class Decoder {
 public:
  explicit Decoder(const Schema& schema);

  const Schema& schema() const { return *schema_; }

  /// Whether the message is whole, without a tree: fixed-size parts are skipped in one step.
  DecodeStatus check(int structure, std::span<const uint8_t> message) const;

  /// Fills `tree`; on failure its nodes are empty.
  DecodeStatus decode(int structure, std::span<const uint8_t> message, Tree& tree) const;

 private:
  struct Length {
    int64_t constant = 0;
    int slot = -1;  // >= 0: the value kept there
  };
  struct Step {
    Node prototype;  // of the field, and of an element when it is a list
    Node element_prototype;
    int structure = -1;  // of a compound field
    Primitive primitive = Primitive::int8;
    uint32_t element_bytes = 0;   // 0: varies
    uint64_t fixed_count = 1;     // product of the constant dimensions
    bool scalar = false;          // one number, boolean or byte
    bool variable = false;        // some dimension is a field
    std::vector<Length> lengths;  // one a dimension
    int slot = -1;                // >= 0: keeps its value there, it is some array's length
    uint64_t run_bytes = 0;       // check: the size in bytes, and steps, of the fixed run from here
    uint32_t run_steps = 0;
  };
  struct Plan {
    std::vector<Step> steps;
    int slots = 0;
    int64_t fixed_bytes = -1;  // -1: varies
    bool compiling = false;
    bool done = false;
  };
  template <bool Build>
  class Walk;

  void compile(int structure);
  void compile_runs(Plan& plan);
  Step compile_step(int structure, const Member& member);

  const Schema* schema_;
  std::vector<Plan> plans_;
  std::vector<std::vector<int>> slot_of_member_;
};

}  // namespace marco::lcm_schema
