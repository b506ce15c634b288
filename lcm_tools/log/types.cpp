#include "lcm_tools/log/types.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/schema/built_in_sources.hpp"

namespace marco::logs {
namespace {

lcm_schema::Schema read_schema(const std::vector<std::string>& paths,
                               std::vector<std::string>& problems) {
  for (const std::string& path : paths) {
    require(std::filesystem::exists(path), "--types " + path + ": there is no such file or folder");
  }
  return lcm_schema::load_schema(built_in_sources(), paths, problems);
}

// Where the last field ends.
std::size_t end_of(const lcm_schema::Tree& tree) {
  constexpr std::size_t kFingerprintBytes = 8;
  for (auto node = tree.nodes.rbegin(); node != tree.nodes.rend(); ++node) {
    if (node->kind == lcm_schema::NodeKind::values) return node->offset + node->bytes;
    if (node->kind != lcm_schema::NodeKind::value) continue;
    const bool text = node->primitive == lcm_schema::Primitive::string;
    return node->offset + (text ? node->bytes + 1 : lcm_schema::wire_bytes(node->primitive));
  }
  return kFingerprintBytes;
}

}  // namespace

Types::Types(const std::vector<std::string>& paths)
    : schema_(read_schema(paths, problems_)), decoder_(schema_) {}

void print_problems(const Types& types) {
  for (const std::string& problem : types.problems()) {
    std::fprintf(stderr, "marco-log: not used: %s\n", problem.c_str());
  }
}

int Types::structure_of(uint64_t fingerprint) const {
  const auto candidates = schema_.with_fingerprint(fingerprint);
  return candidates.empty() ? -1 : candidates.front();
}

std::string Types::name_of(uint64_t fingerprint) const {
  const int structure = structure_of(fingerprint);
  return structure < 0 ? "" : schema_.structures()[static_cast<std::size_t>(structure)].name;
}

int Types::decode(std::span<const uint8_t> message, lcm_schema::Tree& tree) const {
  const auto fingerprint = lcm_schema::fingerprint_of(message);
  if (!fingerprint) return -1;
  for (const int structure : schema_.with_fingerprint(*fingerprint)) {
    if (decoder_.decode(structure, message, tree) == lcm_schema::DecodeStatus::ok) {
      return structure;
    }
  }
  return -1;
}

bool Types::decodes(std::span<const uint8_t> message) const {
  const auto fingerprint = lcm_schema::fingerprint_of(message);
  if (!fingerprint) return true;
  const auto candidates = schema_.with_fingerprint(*fingerprint);
  lcm_schema::Tree tree;
  return candidates.empty() ||
         std::any_of(candidates.begin(), candidates.end(), [&](int structure) {
           return decoder_.decode(structure, message, tree) == lcm_schema::DecodeStatus::ok &&
                  end_of(tree) == message.size();
         });
}

}  // namespace marco::logs
