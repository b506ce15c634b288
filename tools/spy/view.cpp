#include "tools/spy/view.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

namespace marco::spy {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using lcm_schema::Node;
using lcm_schema::NodeKind;
using lcm_schema::Primitive;
using lcm_schema::Tree;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// Moves `position` in a list of `count` as a cursor key says; false for other keys.
bool move(int& position, int count, Key key, int page) {
  switch (key) {
    case Key::up:
      --position;
      break;
    case Key::down:
      ++position;
      break;
    case Key::page_up:
      position -= page;
      break;
    case Key::page_down:
      position += page;
      break;
    case Key::home:
      position = 0;
      break;
    case Key::end:
      position = count - 1;
      break;
    default:
      return false;
  }
  position = std::clamp(position, 0, std::max(0, count - 1));
  return true;
}

void type_filter(View& view, KeyPress press) {
  if (press.key == Key::enter) {
    view.typing_filter = false;
  } else if (press.key == Key::back) {
    view.typing_filter = false;
    view.filter.clear();
  } else if (press.key == Key::erase) {
    if (!view.filter.empty()) view.filter.pop_back();
  } else if (press.key == Key::character && press.character >= ' ' && view.filter.size() < 63) {
    view.filter += press.character;
  }
}

void key_in_table(View& view, KeyPress press, const Model& model, const Surroundings& around) {
  const std::vector<int> rows = visible_channels(model, view, around);
  int row = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (model.channels()[static_cast<std::size_t>(rows[i])].name == view.selected)
      row = static_cast<int>(i);
  }
  const bool moved = move(row, static_cast<int>(rows.size()), press.key, view.page_rows);
  if (!rows.empty() && (moved || view.selected.empty() || press.key == Key::enter)) {
    view.selected =
        model.channels()[static_cast<std::size_t>(rows[static_cast<std::size_t>(row)])].name;
  }
  if (press.key == Key::enter && !rows.empty()) {
    view.page = Page::channel;
    view.cursor.clear();
  }
  if (press.key == Key::back) view.filter.clear();
  if (press.key != Key::character) return;
  if (press.character == 's') {
    view.sort = static_cast<Column>((static_cast<int>(view.sort) + 1) % kColumns);
    // Numbers: the largest first is what one looks for.
    view.descending = view.sort >= Column::count;
  }
  if (press.character == 'r') view.descending = !view.descending;
  if (press.character == '/') view.typing_filter = true;
}

void toggle_plot(View& view, const FieldRow& row) {
  const auto found = std::find(view.plotted.begin(), view.plotted.end(), row.path);
  if (found != view.plotted.end()) {
    view.plotted.erase(found);
  } else if (view.plotted.size() < 4) {
    view.plotted.push_back(row.path);
  }
}

void key_in_channel(View& view, KeyPress press, const Model& model) {
  const int channel = model.find(view.selected);
  Tree tree;
  if (press.key == Key::back) view.page = Page::table;
  if (channel < 0 || !model.decode_last(channel, tree)) return;
  if (press.key == Key::character && press.character == 'v') view.page = Page::picture;
  const std::vector<FieldRow> rows = field_rows(tree, view.selected, view);
  int at = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].path == view.cursor) at = static_cast<int>(i);
  }
  move(at, static_cast<int>(rows.size()), press.key, view.page_rows);
  if (rows.empty()) return;
  const FieldRow& row = rows[static_cast<std::size_t>(at)];
  view.cursor = row.path;
  if (press.key == Key::enter && row.foldable) {
    const std::string key = view.selected + "/" + row.path;
    if (view.unfolded.erase(key) == 0) view.unfolded.insert(key);
  }
  if (press.key != Key::character || !row.numeric) return;
  if (press.character == '+') toggle_plot(view, row);
  if (press.character == 'g') {
    if (view.plotted.empty()) view.plotted.push_back(row.path);
    view.page = Page::plot;
  }
}

void key_in_picture(View& view, KeyPress press) {
  if (press.key == Key::back) {
    if (view.page == Page::plot) view.plotted.clear();
    view.page = Page::channel;
  }
  if (press.key != Key::character) return;
  if (press.character == '+') view.zoom = std::min(64.0, view.zoom * 1.25);
  if (press.character == '-') view.zoom = std::max(0.1, view.zoom / 1.25);
}

}  // namespace

Action handle_key(View& view, KeyPress press, const Model& model, const Surroundings& around) {
  if (view.typing_filter) {
    type_filter(view, press);
    return Action::none;
  }
  if (press.key == Key::character) {
    switch (press.character) {
      case 'q':
        return Action::quit;
      case 'c':
        return Action::clear;
      case 't':
        return Action::next_type;
      case 'p':
      case ' ':
        return Action::pause;
      case 'w':
        view.page = Page::who;
        view.scroll = 0;
        return Action::none;
      case '?':
        view.page = Page::help;
        return Action::none;
      default:
        break;
    }
  }
  switch (view.page) {
    case Page::table:
      key_in_table(view, press, model, around);
      break;
    case Page::channel:
      key_in_channel(view, press, model);
      break;
    case Page::plot:
    case Page::picture:
      key_in_picture(view, press);
      break;
    case Page::who:
    case Page::help:
      if (press.key == Key::back) view.page = Page::table;
      move(view.scroll, 100000, press.key, view.page_rows);
      break;
  }
  return Action::none;
}

Rates rates_of(const Channel& channel, const Surroundings& around) {
  return around.overall_rates ? channel.rate.overall() : channel.rate.recent(around.now_us);
}

std::string type_text(const Model& model, const Channel& channel) {
  if (channel.fingerprint == 0) return "no type";
  if (channel.candidates.empty()) {
    static constexpr char kDigits[] = "0123456789abcdef";
    std::string text = "?? ";
    for (unsigned shift = 64; shift > 0; shift -= 4)
      text += kDigits[channel.fingerprint >> (shift - 4) & 15U];
    return text;
  }
  std::string text =
      model.decoder().schema().structures()[static_cast<std::size_t>(channel.type())].name;
  const std::size_t count = channel.candidates.size();
  if (count > 1)
    text += " (" + std::to_string(channel.choice % count + 1) + "/" + std::to_string(count) + ")";
  return text;
}

std::vector<int> visible_channels(const Model& model,
                                  const View& view,
                                  const Surroundings& around) {
  struct Row {
    int channel;
    std::string text;
    double number;
  };
  std::vector<Row> rows;
  const std::string filter = lower(view.filter);
  for (std::size_t i = 0; i < model.channels().size(); ++i) {
    const Channel& channel = model.channels()[i];
    const std::string type = type_text(model, channel);
    if (lower(channel.name + " " + type).find(filter) == std::string::npos) continue;
    const Rates rates = rates_of(channel, around);
    Row row{static_cast<int>(i), view.sort == Column::type ? type : channel.name, 0};
    switch (view.sort) {
      case Column::channel:
      case Column::type:
        break;
      case Column::count:
        row.number = static_cast<double>(channel.rate.count());
        break;
      case Column::hz:
        row.number = rates.hz;
        break;
      case Column::jitter:
        row.number = rates.jitter_s;
        break;
      case Column::bandwidth:
        row.number = rates.bytes_per_s;
        break;
      case Column::age:
        row.number = static_cast<double>(around.now_us - channel.rate.last_us());
        break;
      case Column::undecodable:
        row.number = static_cast<double>(channel.undecodable());
        break;
      case Column::lost:
        row.number = static_cast<double>(model.loss(static_cast<int>(i)).count);
        break;
    }
    rows.push_back(std::move(row));
  }
  std::stable_sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) {
    if (a.number != b.number) return view.descending ? a.number > b.number : a.number < b.number;
    const bool reverse = view.descending && view.sort <= Column::type;
    return reverse ? a.text > b.text : a.text < b.text;
  });
  std::vector<int> result;
  for (const Row& row : rows) result.push_back(row.channel);
  return result;
}

namespace {

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
      add(static_cast<int>(i), label,
          node.element || path.empty() ? path + label : path + "." + label, depth);
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
