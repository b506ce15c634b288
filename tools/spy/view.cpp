#include "tools/spy/view.hpp"

#include <algorithm>
#include <cctype>

namespace marco::spy {
namespace {

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
  return around.overall_rates ? channel.rate.overall(around.now_us)
                              : channel.rate.recent(around.now_us);
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
  result.reserve(rows.size());
  for (const Row& row : rows) result.push_back(row.channel);
  return result;
}

}  // namespace marco::spy
