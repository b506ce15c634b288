#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lcm_tools/schema/schema.hpp"

namespace marco::lcm_schema {

enum class NodeKind : uint8_t {
  value,      ///< one number, boolean, byte or string
  values,     ///< an array of numbers, booleans or bytes: one node, read by index
  structure,  ///< children: its fields
  list        ///< an array of structs or strings; children: its elements, row by row
};

/// A field of a decoded message: a place in its bytes. Nothing is copied.
struct Node {
  const Member* member = nullptr;  ///< nullptr: the message itself
  uint32_t offset = 0;             ///< [byte] from the message's beginning (of a string: its text)
  uint32_t bytes = 0;              ///< [byte] of a string without its NUL, of an array; else 0
  uint32_t count = 1;              ///< elements of `values` and `list`
  uint32_t after = 0;              ///< index of the next node that is not inside this one
  uint32_t lengths_at = 0;  ///< of arrays: Tree::lengths[lengths_at + d] = length of dimension d
  NodeKind kind = NodeKind::value;
  Primitive primitive = Primitive::int8;  ///< of value and values
  bool element = false;                   ///< an element of the list above, not the field itself
};

/// A decoded message: nodes depth first, node 0 is the message. Children of node i begin at i + 1;
/// the next sibling of a child c is nodes[c].after; they end at nodes[i].after. Reads from the
/// message's bytes: valid while those are. Reuse one Tree for many messages: nothing is allocated
/// once it has grown.
struct Tree {
  std::vector<Node> nodes;
  std::vector<uint32_t> lengths;
  std::span<const uint8_t> message;

  /// Element `i` of a number, boolean or byte node as a double (0 for a string). No bounds check.
  double number(const Node& node, std::size_t i = 0) const;
  /// The same as an integer; of a float, rounded towards 0.
  int64_t integer(const Node& node, std::size_t i = 0) const;
  /// Of a string node; may hold any bytes.
  std::string_view text(const Node& node) const;

  /// Index of the child with this name in the structure node `parent`; -1 when there is none.
  int child(int parent, std::string_view name) const;
  /// Follows "metadata[2].key" from the message; -1 when there is none. An index stands behind a
  /// list only; elements of `values` have no node.
  int find(std::string_view path) const;
  /// "metadata[2].key", "ranges"; "" for the message.
  std::string path(int node) const;
};

/// Calls `visit(node index, element)` for every single value of the tree in wire order: numbers and
/// strings, each element of an array. A flat list of fields for tables: name it with
/// `value_name(tree, node, element)`.
template <class Visit>
void for_each_value(const Tree& tree, Visit&& visit) {
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const Node& node = tree.nodes[i];
    if (node.kind == NodeKind::value) visit(static_cast<int>(i), std::size_t{0});
    if (node.kind != NodeKind::values) continue;
    for (std::size_t element = 0; element < node.count; ++element)
      visit(static_cast<int>(i), element);
  }
}

/// "pose.x", "ranges[3]", "covariance[1][2]".
std::string value_name(const Tree& tree, int node, std::size_t element);

}  // namespace marco::lcm_schema
