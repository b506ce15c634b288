#include "lcm_tools/spy/view.hpp"

#include <algorithm>

#include "lcm_tools/lcmtypes/channels.hpp"

namespace marco::spy {
namespace {

using lcm_schema::Tree;

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
  if (view.asks_release) {
    view.asks_release = false;
    return press.key == Key::character && press.character == 'y' ? Action::release : Action::none;
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
      case 'x':
        return Action::stop;
      case 'X':
        view.asks_release = !around.is_log;
        return Action::none;
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

std::optional<EmergencyStop> emergency_stop(const Model& model) {
  const int channel = model.find(channels::kEmergencyStop);
  Tree tree;
  if (channel < 0 || !model.decode_last(channel, tree)) return std::nullopt;
  const auto node = [&tree](std::string_view name) -> const lcm_schema::Node* {
    const int index = tree.child(0, name);
    return index < 0 ? nullptr : &tree.nodes[static_cast<std::size_t>(index)];
  };
  const auto text = [&](std::string_view name) {
    const lcm_schema::Node* found = node(name);
    const bool is_text = found != nullptr && found->kind == lcm_schema::NodeKind::value &&
                         found->primitive == lcm_schema::Primitive::string;
    return is_text ? std::string(tree.text(*found).substr(0, 200)) : std::string();
  };
  const lcm_schema::Node* engaged = node("engaged");
  if (engaged == nullptr || engaged->primitive != lcm_schema::Primitive::boolean)
    return std::nullopt;
  return EmergencyStop{tree.integer(*engaged) != 0, text("sender"), text("reason")};
}

}  // namespace marco::spy
