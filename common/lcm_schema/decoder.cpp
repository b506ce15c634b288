#include "common/lcm_schema/decoder.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>

#include "common/check.hpp"

namespace marco::lcm_schema {
namespace {

constexpr std::size_t kMaxMessageBytes = std::size_t{1} << 30U;
constexpr std::size_t kMaxNodes = 4U << 20U;
constexpr int kMaxDepth = 64;
constexpr int kMaxSlots = 1024;             // lengths kept at once, over all nested structs
constexpr uint64_t kTooMany = 1ULL << 40U;  // more than any message holds

template <class Int>
Int load(const uint8_t* bytes) {
  Int value;
  std::memcpy(&value, bytes, sizeof(Int));
  if constexpr (sizeof(Int) == 8)
    value = static_cast<Int>(__builtin_bswap64(static_cast<uint64_t>(value)));
  if constexpr (sizeof(Int) == 4)
    value = static_cast<Int>(__builtin_bswap32(static_cast<uint32_t>(value)));
  if constexpr (sizeof(Int) == 2)
    value = static_cast<Int>(__builtin_bswap16(static_cast<uint16_t>(value)));
  return value;
}

uint64_t bounded_product(uint64_t a, uint64_t b) {
  return a != 0 && b > kTooMany / a ? kTooMany : a * b;
}

int64_t load_integer(Primitive primitive, const uint8_t* bytes) {
  switch (primitive) {
    case Primitive::int8:
    case Primitive::boolean:
      return static_cast<int8_t>(*bytes);
    case Primitive::byte:
      return *bytes;
    case Primitive::int16:
      return load<int16_t>(bytes);
    case Primitive::int32:
      return load<int32_t>(bytes);
    case Primitive::int64:
      return load<int64_t>(bytes);
    default:
      return 0;
  }
}

}  // namespace

const char* name_of(DecodeStatus status) {
  switch (status) {
    case DecodeStatus::ok:
      return "ok";
    case DecodeStatus::wrong_fingerprint:
      return "wrong fingerprint";
    case DecodeStatus::truncated:
      return "truncated";
    case DecodeStatus::bad_length:
      return "bad length";
    case DecodeStatus::too_deep:
      return "nested too deep";
    case DecodeStatus::too_large:
      return "too large";
  }
  return "";
}

double Tree::number(const Node& node, std::size_t i) const {
  const uint8_t* at = message.data() + node.offset + i * wire_bytes(node.primitive);
  if (node.primitive == Primitive::float32)
    return static_cast<double>(std::bit_cast<float>(load<uint32_t>(at)));
  if (node.primitive == Primitive::float64) return std::bit_cast<double>(load<uint64_t>(at));
  return static_cast<double>(load_integer(node.primitive, at));
}

int64_t Tree::integer(const Node& node, std::size_t i) const {
  if (node.primitive == Primitive::float32 || node.primitive == Primitive::float64) {
    const double value = number(node, i);
    return value > -9.2e18 && value < 9.2e18 ? static_cast<int64_t>(value) : 0;
  }
  return load_integer(node.primitive,
                      message.data() + node.offset + i * wire_bytes(node.primitive));
}

std::string_view Tree::text(const Node& node) const {
  if (node.kind != NodeKind::value || node.primitive != Primitive::string) return {};
  return {reinterpret_cast<const char*>(message.data()) + node.offset, node.bytes};
}

int Tree::child(int parent, std::string_view name) const {
  if (parent < 0 || parent >= static_cast<int>(nodes.size())) return -1;
  const Node& above = nodes[static_cast<std::size_t>(parent)];
  if (above.kind != NodeKind::structure) return -1;
  for (std::size_t i = static_cast<std::size_t>(parent) + 1; i < above.after; i = nodes[i].after) {
    if (nodes[i].member->name == name) return static_cast<int>(i);
  }
  return -1;
}

int Tree::find(std::string_view path) const {
  int node = 0;
  while (node >= 0 && !path.empty()) {
    if (path.front() == '.') path.remove_prefix(1);
    if (path.front() != '[') {
      const std::string_view name = path.substr(0, path.find_first_of(".["));
      path.remove_prefix(name.size());
      node = child(node, name);
      continue;
    }
    const std::size_t end = path.find(']');
    uint32_t wanted = 0;
    const char* last = path.data() + (end == std::string_view::npos ? path.size() : end);
    const Node& list = nodes[static_cast<std::size_t>(node)];
    if (end == std::string_view::npos || list.kind != NodeKind::list ||
        std::from_chars(path.data() + 1, last, wanted).ptr != last || wanted >= list.count) {
      return -1;
    }
    std::size_t i = static_cast<std::size_t>(node) + 1;
    for (uint32_t k = 0; k < wanted; ++k) i = nodes[i].after;
    node = static_cast<int>(i);
    path.remove_prefix(end + 1);
  }
  return node;
}

std::string Tree::path(int node) const {
  std::string result;
  const auto target = static_cast<std::size_t>(node);
  std::size_t at = 0;
  while (at < target) {
    const NodeKind kind = nodes[at].kind;
    std::size_t inner = at + 1;
    uint32_t index = 0;
    for (; nodes[inner].after <= target; inner = nodes[inner].after) ++index;
    if (kind == NodeKind::list) {
      result += '[' + std::to_string(index) + ']';
    } else {
      result += (result.empty() ? "" : ".") + nodes[inner].member->name;
    }
    at = inner;
  }
  return result;
}

std::string value_name(const Tree& tree, int node, std::size_t element) {
  const Node& field = tree.nodes[static_cast<std::size_t>(node)];
  std::string result = tree.path(node);
  if (field.kind != NodeKind::values) return result;
  std::string indices;
  for (std::size_t d = field.member->dimensions.size(); d-- > 0;) {
    const std::size_t length = tree.lengths[field.lengths_at + d];
    indices = '[' + std::to_string(element % length) + ']' + indices;
    element /= length;
  }
  return result + indices;
}

Decoder::Decoder(const Schema& schema)
    : schema_(&schema), plans_(schema.structures().size()), slot_of_member_(plans_.size()) {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    const Structure& structure = schema.structures()[i];
    slot_of_member_[i].assign(structure.members.size(), -1);
    for (const Member& member : structure.members) {
      for (const Dimension& dimension : member.dimensions) {
        if (dimension.member < 0) continue;
        int& slot = slot_of_member_[i][static_cast<std::size_t>(dimension.member)];
        if (slot < 0) slot = plans_[i].slots++;
      }
    }
  }
  for (std::size_t i = 0; i < plans_.size(); ++i) compile(static_cast<int>(i));
}

void Decoder::compile(int structure) {
  Plan& plan = plans_[static_cast<std::size_t>(structure)];
  const Structure& type = schema_->structures()[static_cast<std::size_t>(structure)];
  if (plan.done || plan.compiling || !type.complete || type.is_enum) return;
  plan.compiling = true;
  for (const Member& member : type.members) plan.steps.push_back(compile_step(structure, member));
  compile_runs(plan);
  plan.compiling = false;
  plan.done = true;
}

Decoder::Step Decoder::compile_step(int structure, const Member& member) {
  Step step;
  step.member = &member;
  if (member.primitive) {
    step.primitive = *member.primitive;
    step.element_bytes = static_cast<uint32_t>(wire_bytes(*member.primitive));
  } else {
    step.structure = member.structure;
    compile(member.structure);
  }
  const std::vector<int>& slots = slot_of_member_[static_cast<std::size_t>(structure)];
  for (const Dimension& dimension : member.dimensions) {
    if (dimension.member >= 0) {
      step.variable = true;
      step.lengths.push_back({0, slots[static_cast<std::size_t>(dimension.member)]});
    } else {
      step.lengths.push_back({dimension.constant, -1});
      step.fixed_count =
          bounded_product(step.fixed_count, static_cast<uint64_t>(dimension.constant));
    }
  }
  const Structure& type = schema_->structures()[static_cast<std::size_t>(structure)];
  step.slot = slots[static_cast<std::size_t>(&member - type.members.data())];
  return step;
}

void Decoder::compile_runs(Plan& plan) {
  plan.fixed_bytes = 0;
  for (std::size_t i = plan.steps.size(); i-- > 0;) {
    Step& step = plan.steps[i];
    int64_t element = step.element_bytes > 0 ? static_cast<int64_t>(step.element_bytes) : -1;
    if (step.structure >= 0) {
      const Plan& inner = plans_[static_cast<std::size_t>(step.structure)];
      element = inner.done ? inner.fixed_bytes : -1;
    }
    if (element < 0 || step.variable) {
      plan.fixed_bytes = -1;
      continue;
    }
    const uint64_t bytes = bounded_product(step.fixed_count, static_cast<uint64_t>(element));
    if (plan.fixed_bytes >= 0) {
      plan.fixed_bytes =
          static_cast<int64_t>(std::min(kTooMany, static_cast<uint64_t>(plan.fixed_bytes) + bytes));
    }
    if (step.slot >= 0) continue;
    const bool joined = i + 1 < plan.steps.size();
    step.run_bytes = std::min(kTooMany, bytes + (joined ? plan.steps[i + 1].run_bytes : 0));
    step.run_steps = 1 + (joined ? plan.steps[i + 1].run_steps : 0);
  }
}

template <bool kBuild>
class Decoder::Walk {
 public:
  Walk(const Decoder& decoder, std::span<const uint8_t> message, Tree* tree)
      : decoder_(decoder), message_(message), tree_(tree) {}

  DecodeStatus run(int structure) {
    at_ = 8;
    if constexpr (kBuild) open({}, NodeKind::structure);
    const DecodeStatus status = fields(structure, 0);
    if constexpr (kBuild) close(0);
    return status;
  }

 private:
  std::size_t left() const { return message_.size() - at_; }

  std::size_t open(const Member* member, NodeKind kind) {
    Node node;
    node.member = member;
    node.offset = static_cast<uint32_t>(at_);
    node.kind = kind;
    tree_->nodes.push_back(node);
    return tree_->nodes.size() - 1;
  }
  void close(std::size_t node) {
    tree_->nodes[node].after = static_cast<uint32_t>(tree_->nodes.size());
  }

  DecodeStatus fields(int structure, int depth) {
    const Plan& plan = decoder_.plans_[static_cast<std::size_t>(structure)];
    if (depth > kMaxDepth || slots_used_ + plan.slots > kMaxSlots) return DecodeStatus::too_deep;
    int64_t* const slots = slots_.data() + slots_used_;
    slots_used_ += plan.slots;
    const std::size_t count = plan.steps.size();
    for (std::size_t i = 0; i < count;) {
      const Step& step = plan.steps[i];
      if constexpr (!kBuild) {
        if (step.run_steps > 0) {
          if (step.run_bytes > left()) return DecodeStatus::truncated;
          at_ += step.run_bytes;
          i += step.run_steps;
          continue;
        }
      }
      const DecodeStatus status = field(step, slots, depth);
      if (status != DecodeStatus::ok) return status;
      ++i;
    }
    slots_used_ -= plan.slots;
    return DecodeStatus::ok;
  }

  DecodeStatus field(const Step& step, int64_t* slots, int depth) {
    if constexpr (kBuild) {
      if (tree_->nodes.size() >= kMaxNodes) return DecodeStatus::too_large;
    }
    if (!step.member->dimensions.empty()) return array(step, slots, depth);
    if (step.structure >= 0) return nested(step, depth, false);
    if (step.primitive == Primitive::string) return string(step, false);
    if (step.element_bytes > left()) return DecodeStatus::truncated;
    if (step.slot >= 0) slots[step.slot] = load_integer(step.primitive, message_.data() + at_);
    if constexpr (kBuild) {
      const std::size_t node = open(step.member, NodeKind::value);
      tree_->nodes[node].primitive = step.primitive;
      close(node);
    }
    at_ += step.element_bytes;
    return DecodeStatus::ok;
  }

  DecodeStatus nested(const Step& step, int depth, bool element) {
    if constexpr (!kBuild) return fields(step.structure, depth + 1);
    const std::size_t node = open(step.member, NodeKind::structure);
    tree_->nodes[node].element = element;
    const DecodeStatus status = fields(step.structure, depth + 1);
    close(node);
    return status;
  }

  DecodeStatus string(const Step& step, bool element) {
    if (left() < 4) return DecodeStatus::truncated;
    const auto length = load<int32_t>(message_.data() + at_);
    if (length < 1) return DecodeStatus::bad_length;
    at_ += 4;
    if (static_cast<std::size_t>(length) > left()) return DecodeStatus::truncated;
    if constexpr (kBuild) {
      const std::size_t node = open(step.member, NodeKind::value);
      tree_->nodes[node].primitive = Primitive::string;
      tree_->nodes[node].bytes = static_cast<uint32_t>(length - 1);
      tree_->nodes[node].element = element;
      close(node);
    }
    at_ += static_cast<std::size_t>(length);
    return DecodeStatus::ok;
  }

  DecodeStatus array(const Step& step, const int64_t* slots, int depth) {
    uint64_t count = step.fixed_count;
    if (step.variable) {
      for (const Length& kept : step.lengths) {
        if (kept.slot < 0) continue;
        const int64_t length = slots[kept.slot];
        if (length < 0) return DecodeStatus::bad_length;
        count = bounded_product(count, static_cast<uint64_t>(length));
      }
    }
    std::size_t node = 0;
    if constexpr (kBuild) node = open_array(step, slots);
    const DecodeStatus status =
        step.element_bytes > 0 ? numbers(step, count) : elements(step, count, depth);
    if constexpr (kBuild) {
      tree_->nodes[node].count = static_cast<uint32_t>(std::min<uint64_t>(count, UINT32_MAX));
      tree_->nodes[node].bytes = static_cast<uint32_t>(at_) - tree_->nodes[node].offset;
      close(node);
    }
    return status;
  }

  std::size_t open_array(const Step& step, const int64_t* slots) {
    const bool flat = step.element_bytes > 0;
    const std::size_t node = open(step.member, flat ? NodeKind::values : NodeKind::list);
    tree_->nodes[node].primitive = step.primitive;
    tree_->nodes[node].lengths_at = static_cast<uint32_t>(tree_->lengths.size());
    for (const Length& kept : step.lengths) {
      const int64_t length = kept.slot < 0 ? kept.constant : slots[kept.slot];
      tree_->lengths.push_back(static_cast<uint32_t>(std::min<int64_t>(length, UINT32_MAX)));
    }
    return node;
  }

  DecodeStatus numbers(const Step& step, uint64_t count) {
    const uint64_t bytes = bounded_product(count, step.element_bytes);
    if (bytes > left()) return DecodeStatus::truncated;
    at_ += bytes;
    return DecodeStatus::ok;
  }

  DecodeStatus elements(const Step& step, uint64_t count, int depth) {
    if constexpr (!kBuild) {
      if (step.structure >= 0) {
        const Plan& inner = decoder_.plans_[static_cast<std::size_t>(step.structure)];
        if (inner.fixed_bytes >= 0) {
          const uint64_t bytes = bounded_product(count, static_cast<uint64_t>(inner.fixed_bytes));
          if (bytes > left()) return DecodeStatus::truncated;
          at_ += bytes;
          return DecodeStatus::ok;
        }
      }
    }
    for (uint64_t i = 0; i < count; ++i) {
      if constexpr (kBuild) {
        if (tree_->nodes.size() >= kMaxNodes) return DecodeStatus::too_large;
      }
      const DecodeStatus status =
          step.structure >= 0 ? nested(step, depth, true) : string(step, true);
      if (status != DecodeStatus::ok) return status;
    }
    return DecodeStatus::ok;
  }

  const Decoder& decoder_;
  std::span<const uint8_t> message_;
  Tree* tree_;
  std::size_t at_ = 0;
  int slots_used_ = 0;
  std::array<int64_t, kMaxSlots> slots_;
};

DecodeStatus Decoder::check(int structure, std::span<const uint8_t> message) const {
  const Structure& type = schema_->structures().at(static_cast<std::size_t>(structure));
  require(type.complete && !type.is_enum, type.name + " cannot be decoded");
  if (message.size() > kMaxMessageBytes) return DecodeStatus::too_large;
  if (fingerprint_of(message) != type.fingerprint) return DecodeStatus::wrong_fingerprint;
  return Walk<false>(*this, message, nullptr).run(structure);
}

DecodeStatus Decoder::decode(int structure, std::span<const uint8_t> message, Tree& tree) const {
  const Structure& type = schema_->structures().at(static_cast<std::size_t>(structure));
  require(type.complete && !type.is_enum, type.name + " cannot be decoded");
  tree.nodes.clear();
  tree.lengths.clear();
  tree.message = message;
  if (message.size() > kMaxMessageBytes) return DecodeStatus::too_large;
  if (fingerprint_of(message) != type.fingerprint) return DecodeStatus::wrong_fingerprint;
  const DecodeStatus status = Walk<true>(*this, message, &tree).run(structure);
  if (status != DecodeStatus::ok) tree.nodes.clear();
  return status;
}

}  // namespace marco::lcm_schema
