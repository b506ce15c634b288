#include "lcm_tools/schema/tree.hpp"

#include <bit>
#include <charconv>

#include "lcm_tools/schema/wire.hpp"

namespace marco::lcm_schema {
namespace {

std::string bracketed(std::size_t index) {
  std::string text = "[";
  text += std::to_string(index);
  text += ']';
  return text;
}

}  // namespace

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
      result += bracketed(index);
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
    indices.insert(0, bracketed(element % length));
    element /= length;
  }
  return result + indices;
}

}  // namespace marco::lcm_schema
