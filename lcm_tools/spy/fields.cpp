#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "lcm_tools/spy/view.hpp"

namespace marco::spy {
namespace {

using lcm_schema::Node;
using lcm_schema::NodeKind;
using lcm_schema::Primitive;
using lcm_schema::Tree;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMaxRows = 3000;
constexpr std::size_t kMaxElementRows = 1000;

std::string enclosed(char left, std::string_view text, char right) {
  std::string result(1, left);
  result += text;
  result += right;
  return result;
}

class Rows {
 public:
  Rows(const Tree& tree, const std::string& channel, const View& view)
      : tree_(tree), channel_(channel), view_(view) {}

  std::vector<FieldRow> take() {
    children(0, "", 0);
    return std::move(rows_);
  }

 private:
  bool unfolded(const std::string& path) const {
    return view_.unfolded.contains(channel_ + "/" + path);
  }

  void children(int parent, const std::string& path, int depth) {
    const Node& above = tree_.nodes[static_cast<std::size_t>(parent)];
    std::size_t element = 0;
    for (std::size_t i = static_cast<std::size_t>(parent) + 1;
         i < above.after && rows_.size() < kMaxRows; i = tree_.nodes[i].after) {
      const Node& node = tree_.nodes[i];
      const std::string label =
          node.element ? enclosed('[', std::to_string(element++), ']') : node.member->name;
      if (node.element && element > kMaxElementRows) return;
      std::string inner = path;
      if (!node.element && !path.empty()) inner += '.';
      inner += label;
      add(static_cast<int>(i), label, inner, depth);
    }
  }

  void add(int index, const std::string& label, const std::string& path, int depth) {
    const Node& node = tree_.nodes[static_cast<std::size_t>(index)];
    FieldRow row{path, depth, label, node.member->type, "", false, false, false, index};
    if (!node.element) {
      for (std::size_t d = 0; d < node.member->dimensions.size(); ++d) {
        row.type += enclosed('[', std::to_string(tree_.lengths[node.lengths_at + d]), ']');
      }
    }
    row.foldable = node.kind != NodeKind::value;
    if (node.kind == NodeKind::value) {
      row.value = value_text(node, 0);
      row.numeric = node.primitive != Primitive::string;
    }
    if (node.kind == NodeKind::values) {
      row.profile = true;
      for (std::size_t i = 0; i < std::min<std::size_t>(node.count, 12); ++i)
        row.value += value_text(node, i) + " ";
      if (node.count > 12) row.value += "..";
    }
    if (node.kind == NodeKind::list) row.value = std::to_string(node.count) + " elements";
    rows_.push_back(row);
    if (!row.foldable || !unfolded(path)) return;
    if (node.kind == NodeKind::values) {
      elements(index, path, depth + 1);
    } else {
      children(index, path, depth + 1);
    }
  }

  void elements(int index, const std::string& path, int depth) {
    const Node& node = tree_.nodes[static_cast<std::size_t>(index)];
    const std::size_t count = std::min<std::size_t>(node.count, kMaxElementRows);
    for (std::size_t i = 0; i < count && rows_.size() < kMaxRows; ++i) {
      const std::string full = lcm_schema::value_name(tree_, index, i);
      const std::string indices = full.substr(
          full.size() - (full.size() - full.rfind(node.member->name) - node.member->name.size()));
      rows_.push_back(
          {path + indices, depth, indices, "", value_text(node, i), false, true, false, index});
    }
  }

  std::string value_text(const Node& node, std::size_t i) const {
    switch (node.primitive) {
      case Primitive::string:
        return enclosed('"', tree_.text(node).substr(0, 200), '"');
      case Primitive::boolean:
        return tree_.integer(node, i) != 0 ? "true" : "false";
      case Primitive::float32:
      case Primitive::float64:
        return plain_number(tree_.number(node, i));
      default:
        return std::to_string(tree_.integer(node, i));
    }
  }

  const Tree& tree_;
  const std::string& channel_;
  const View& view_;
  std::vector<FieldRow> rows_;
};

}  // namespace

std::vector<FieldRow> field_rows(const Tree& tree, const std::string& channel, const View& view) {
  return tree.nodes.empty() ? std::vector<FieldRow>() : Rows(tree, channel, view).take();
}

double value_at(const Tree& tree, const std::string& path) {
  if (const int whole = tree.find(path); whole > 0) {
    const Node& node = tree.nodes[static_cast<std::size_t>(whole)];
    return node.kind == NodeKind::value && node.primitive != Primitive::string ? tree.number(node)
                                                                               : kNaN;
  }
  // Elements of an array of numbers: "name[i][j]", the array's own brackets last.
  for (std::size_t bracket = path.find('['); bracket != std::string::npos;
       bracket = path.find('[', bracket + 1)) {
    const int index = tree.find(path.substr(0, bracket));
    if (index <= 0 || tree.nodes[static_cast<std::size_t>(index)].kind != NodeKind::values)
      continue;
    const Node& node = tree.nodes[static_cast<std::size_t>(index)];
    std::size_t element = 0;
    const char* at = path.data() + bracket;
    for (std::size_t d = 0; d < node.member->dimensions.size(); ++d) {
      std::size_t i = 0;
      const std::size_t length = tree.lengths[node.lengths_at + d];
      const auto [end, error] = std::from_chars(at + 1, path.data() + path.size(), i);
      if (*at != '[' || error != std::errc() || i >= length) return kNaN;
      element = element * length + i;
      at = end + 1;
    }
    return element < node.count ? tree.number(node, element) : kNaN;
  }
  return kNaN;
}

Series series_of(const Model& model,
                 const Channel& channel,
                 const std::string& path,
                 std::size_t limit) {
  Series series;
  if (channel.type() < 0) return series;
  Tree tree;
  const std::size_t count = std::min(limit, channel.history.size());
  for (std::size_t i = channel.history.size() - count; i < channel.history.size(); ++i) {
    const Sample& sample = channel.history[i];
    if (model.decoder().decode(channel.type(), sample.bytes, tree) != lcm_schema::DecodeStatus::ok)
      continue;
    series.times_us.push_back(sample.time_us);
    series.values.push_back(value_at(tree, path));
  }
  return series;
}

}  // namespace marco::spy
