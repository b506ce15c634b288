#include "lcm_tools/schema/decoder.hpp"

#include <algorithm>
#include <array>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/schema/wire.hpp"

namespace marco::lcm_schema {
namespace {

constexpr std::size_t kMaxMessageBytes = std::size_t{1} << 30U;
constexpr std::size_t kMaxNodes = 1U << 20U;
constexpr int kMaxDepth = 64;
constexpr int kMaxSlots = 1024;             // lengths kept at once, over all nested structs
constexpr uint64_t kTooMany = 1ULL << 40U;  // more than any message holds

uint64_t bounded_product(uint64_t a, uint64_t b) {
  return a != 0 && b > kTooMany / a ? kTooMany : a * b;
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
      return "nested too deeply";
    case DecodeStatus::too_large:
      return "too large";
  }
  return "";
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
  step.scalar = member.dimensions.empty() && step.element_bytes > 0;
  step.prototype.member = &member;
  step.prototype.primitive = step.primitive;
  step.prototype.kind = step.structure >= 0 ? NodeKind::structure : NodeKind::value;
  step.element_prototype = step.prototype;
  step.element_prototype.element = true;
  if (!member.dimensions.empty()) {
    step.prototype.kind = step.element_bytes > 0 ? NodeKind::values : NodeKind::list;
  }
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

template <bool Build>
class Decoder::Walk {
 public:
  Walk(const Decoder& decoder, std::span<const uint8_t> message, Tree* tree)
      : decoder_(decoder), message_(message), tree_(tree) {}

  DecodeStatus run(int structure) {
    at_ = 8;
    DecodeStatus status = DecodeStatus::ok;
    if constexpr (Build) {
      static const Node kMessageNode = [] {
        Node node;
        node.kind = NodeKind::structure;
        return node;
      }();
      // Nodes of the message before are overwritten in place: nothing is initialised twice.
      open(kMessageNode);
      status = fields(structure, 0);
      close(0);
      tree_->nodes.resize(used_);
    } else {
      status = fields(structure, 0);
    }
    return status;
  }

 private:
  std::size_t left() const { return message_.size() - at_; }

  std::size_t open(const Node& prototype) {
    if (used_ == tree_->nodes.size()) tree_->nodes.resize(std::max<std::size_t>(64, 2 * used_));
    Node& node = tree_->nodes[used_];
    node = prototype;
    node.offset = static_cast<uint32_t>(at_);
    node.after = static_cast<uint32_t>(used_ + 1);
    return used_++;
  }
  void close(std::size_t node) { tree_->nodes[node].after = static_cast<uint32_t>(used_); }

  DecodeStatus fields(int structure, int depth) {
    const Plan& plan = decoder_.plans_[static_cast<std::size_t>(structure)];
    if (depth > kMaxDepth || slots_used_ + plan.slots > kMaxSlots) return DecodeStatus::too_deep;
    int64_t* const slots = slots_.data() + slots_used_;
    slots_used_ += plan.slots;
    const std::size_t count = plan.steps.size();
    for (std::size_t i = 0; i < count;) {
      const Step& step = plan.steps[i];
      if constexpr (!Build) {
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
    if constexpr (Build) {
      if (used_ >= kMaxNodes) return DecodeStatus::too_large;
    }
    if (!step.scalar) {
      if (!step.lengths.empty()) return array(step, slots, depth);
      if (step.structure >= 0) return nested(step, depth, false);
      return string(step, false);
    }
    if (step.element_bytes > left()) return DecodeStatus::truncated;
    if (step.slot >= 0) slots[step.slot] = load_integer(step.primitive, message_.data() + at_);
    if constexpr (Build) {
      open(step.prototype);
    }
    at_ += step.element_bytes;
    return DecodeStatus::ok;
  }

  DecodeStatus nested(const Step& step, int depth, bool element) {
    if constexpr (!Build) return fields(step.structure, depth + 1);
    const std::size_t node = open(element ? step.element_prototype : step.prototype);
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
    if constexpr (Build) {
      const std::size_t node = open(element ? step.element_prototype : step.prototype);
      tree_->nodes[node].bytes = static_cast<uint32_t>(length - 1);
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
    if constexpr (Build) node = open_array(step, slots);
    const DecodeStatus status =
        step.element_bytes > 0 ? numbers(step, count) : elements(step, count, depth);
    if constexpr (Build) {
      tree_->nodes[node].count = static_cast<uint32_t>(std::min<uint64_t>(count, UINT32_MAX));
      tree_->nodes[node].bytes = static_cast<uint32_t>(at_) - tree_->nodes[node].offset;
      close(node);
    }
    return status;
  }

  std::size_t open_array(const Step& step, const int64_t* slots) {
    const std::size_t node = open(step.prototype);
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
    if constexpr (!Build) {
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
      if constexpr (Build) {
        if (used_ >= kMaxNodes) return DecodeStatus::too_large;
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
  std::size_t used_ = 0;  // of tree_->nodes
  int slots_used_ = 0;
  std::array<int64_t, kMaxSlots> slots_;
};

DecodeStatus Decoder::check(int structure, std::span<const uint8_t> message) const {
  const Structure& type = schema_->structures().at(static_cast<std::size_t>(structure));
  if (!type.complete || type.is_enum) require(false, type.name + " cannot be decoded");
  if (message.size() > kMaxMessageBytes) return DecodeStatus::too_large;
  if (fingerprint_of(message) != type.fingerprint) return DecodeStatus::wrong_fingerprint;
  return Walk<false>(*this, message, nullptr).run(structure);
}

DecodeStatus Decoder::decode(int structure, std::span<const uint8_t> message, Tree& tree) const {
  const Structure& type = schema_->structures().at(static_cast<std::size_t>(structure));
  if (!type.complete || type.is_enum) require(false, type.name + " cannot be decoded");
  tree.lengths.clear();
  tree.message = message;
  DecodeStatus status = DecodeStatus::wrong_fingerprint;
  if (message.size() > kMaxMessageBytes) {
    status = DecodeStatus::too_large;
  } else if (fingerprint_of(message) == type.fingerprint) {
    status = Walk<true>(*this, message, &tree).run(structure);
  }
  if (status != DecodeStatus::ok) tree.nodes.clear();
  return status;
}

}  // namespace marco::lcm_schema
