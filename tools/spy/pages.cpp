#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tools/spy/view.hpp"

namespace marco::spy {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string plural(int64_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string age_text(double age_s) {
  if (age_s < 0) age_s = 0;
  if (age_s < 99.95) return plain_number(std::round(age_s * 10) / 10) + " s";
  if (age_s < 5999) return std::to_string(static_cast<int64_t>(age_s / 60)) + " min";
  return std::to_string(static_cast<int64_t>(age_s / 3600)) + " h";
}

std::string loss_text(const Loss& loss) {
  std::string text(loss.estimated ? "~" : "");
  text += short_number(static_cast<double>(loss.count));
  return text;
}

struct ColumnPlace {
  Column column;
  const char* title;
  int width;
};

constexpr std::array<ColumnPlace, 7> kNumberColumns = {{{Column::count, "COUNT", 8},
                                                        {Column::hz, "HZ", 7},
                                                        {Column::jitter, "JITTER", 9},
                                                        {Column::bandwidth, "B/S", 7},
                                                        {Column::age, "AGE", 8},
                                                        {Column::undecodable, "UNDEC", 6},
                                                        {Column::lost, "LOST", 7}}};

std::string cell_text(const Model& model, int index, Column column, const Surroundings& around) {
  const Channel& channel = model.channels()[static_cast<std::size_t>(index)];
  const Rates rates = rates_of(channel, around);
  switch (column) {
    case Column::count:
      return std::to_string(channel.rate.count());
    case Column::hz:
      return short_number(rates.hz);
    case Column::jitter:
      return short_number(rates.jitter_s * 1e3) + " ms";
    case Column::bandwidth:
      return short_number(rates.bytes_per_s);
    case Column::age:
      return age_text(static_cast<double>(around.now_us - channel.rate.last_us()) * 1e-6);
    case Column::undecodable:
      return short_number(static_cast<double>(channel.undecodable()));
    case Column::lost:
      return around.is_log ? "" : loss_text(model.loss(index));
    default:
      return "";
  }
}

Style cell_style(const Model& model, int index, Column column, const Surroundings& around) {
  const Channel& channel = model.channels()[static_cast<std::size_t>(index)];
  if (column == Column::undecodable) {
    return channel.damaged > 0 ? Style::bad : channel.undecodable() > 0 ? Style::warn : Style::dim;
  }
  if (column == Column::lost) return model.loss(index).count > 0 ? Style::bad : Style::dim;
  // Silent for three of its intervals.
  const double age_s = static_cast<double>(around.now_us - channel.rate.last_us()) * 1e-6;
  if (column == Column::age && !around.overall_rates && channel.rate.overall().hz > 0 &&
      age_s > 1 && age_s > 3 / channel.rate.overall().hz) {
    return Style::warn;
  }
  return Style::normal;
}

// Keeps `selected` among `count` rows on screen. @returns the first row shown.
int first_row(int selected, int count, int shown) {
  return std::clamp(selected - shown / 2, 0, std::max(0, count - shown));
}

void draw_title(Canvas& canvas, const Model& model, const View& view, const Surroundings& around) {
  std::string text = " marco-spy  " + around.source;
  if (view.page != Page::table && view.page != Page::who && view.page != Page::help)
    text += "  " + view.selected;
  if (around.is_log && !around.overall_rates)
    text += around.log_ended ? "  (end of the log)" : "  x" + plain_number(around.speed);
  const double seconds = static_cast<double>(model.last_us() - model.first_us()) * 1e-6;
  std::string right = plural(static_cast<int64_t>(model.channels().size()), "channel") + "  " +
                      plural(model.messages(), "message");
  if (model.messages() > 0) right += "  " + age_text(seconds);
  if (model.lost() > 0) right += "  lost " + std::to_string(model.lost());
  canvas.text(0, 0, text);
  canvas.text_right(canvas.width() - 1, 0, "  " + right);
  canvas.style_row(0, Style::title);
  if (view.paused) canvas.text(canvas.width() / 2 - 4, 0, " PAUSED ", Style::warn);
}

void draw_keys(Canvas& canvas, const View& view) {
  const int y = canvas.height() - 1;
  std::string text;
  switch (view.page) {
    case Page::table:
      text =
          "Enter open  s sort  r reverse  / filter  p pause  c clear  t type  w who  ? help  q "
          "quit";
      break;
    case Page::channel:
      text = "Enter fold  g plot  + add to plot  v picture  t type  p pause  Esc back  q quit";
      break;
    case Page::plot:
    case Page::picture:
      text = "+ - zoom  p pause  Esc back  q quit";
      break;
    case Page::who:
    case Page::help:
      text = "Esc back  q quit";
      break;
  }
  if (view.typing_filter) text = "filter: " + view.filter + "_   (Enter keeps it, Esc drops it)";
  canvas.text(0, y, text, view.typing_filter ? Style::warn : Style::dim);
  if (!view.typing_filter && !view.filter.empty() && view.page == Page::table) {
    canvas.text_right(canvas.width() - 1, y, "  filter: " + view.filter, Style::warn);
  }
}

// Findings and problems, from row y down. @returns the row behind.
int draw_findings(Canvas& canvas, const Surroundings& around, int y, bool all) {
  for (const Finding& finding : around.findings) {
    if (y + 1 >= canvas.height()) return y;
    canvas.text(1, y++, "! " + finding.text, Style::warn);
    if (!finding.command.empty() && y + 1 < canvas.height())
      canvas.text(5, y++, finding.command, Style::bold);
  }
  std::size_t shown = 0;
  for (const std::string& problem : around.problems) {
    if (y + 1 >= canvas.height() || (!all && ++shown > 3)) break;
    canvas.text(1, y++, "! " + problem, Style::warn);
  }
  return y;
}

// The last message and, of a tiled map, the newest of each other tile of the same revision.
std::vector<lcm_schema::Tree> picture_messages(const Model& model, int index) {
  std::vector<lcm_schema::Tree> messages(1);
  if (index < 0 || !model.decode_last(index, messages[0])) return {};
  const Channel& channel = model.channels()[static_cast<std::size_t>(index)];
  for (auto sample = channel.history.rbegin(); channel.tiled && sample != channel.history.rend();
       ++sample) {
    lcm_schema::Tree tree;
    if (model.decoder().decode(channel.type(), sample->bytes, tree) != lcm_schema::DecodeStatus::ok)
      continue;
    const bool other = std::all_of(
        messages.begin(), messages.end(),
        [&](const lcm_schema::Tree& known) { return same_map_other_tile(known, tree); });
    if (other) messages.push_back(std::move(tree));
  }
  return messages;
}

void draw_help(Canvas& canvas, const Surroundings& around) {
  static constexpr const char* kLines[] = {
      "HZ        messages a second over the last 2 s (a log at once: over the whole log)",
      "JITTER    longest minus shortest interval in that time",
      "B/S       bytes a second      AGE  since the last message",
      "UNDEC     messages of no known type, damaged, or without a type",
      "LOST      messages that never came: gaps in the senders' numbers and fragments; ~ shared "
      "out",
      "          among the channels of a sender by their rates, since a lost number names no "
      "channel",
      "",
      "Enter     opens a channel, folds and unfolds a field      Esc  goes back",
      "s r /     sort by the next column, reverse, filter by name or type",
      "g + v     plot the field, add it to the plot, draw scan, grid or image (+ and - zoom)",
      "t         another type with the same fingerprint",
      "p c w     pause, forget and count anew, who publishes and who loses"};
  int y = 2;
  for (const char* line : kLines) canvas.text(2, y++, line);
  draw_findings(canvas, around, y + 1, true);
}

}  // namespace

Canvas draw(const Model& model, View& view, const Surroundings& around, int width, int height) {
  Canvas canvas(width, height);
  switch (view.page) {
    case Page::table:
      draw_table(canvas, model, view, around);
      break;
    case Page::channel:
      draw_channel(canvas, model, view, around);
      break;
    case Page::plot:
      draw_plot(canvas, model, view);
      break;
    case Page::who:
      draw_who(canvas, model, view, around);
      break;
    case Page::help:
      draw_help(canvas, around);
      break;
    case Page::picture: {
      const int channel = model.find(view.selected);
      const std::vector<lcm_schema::Tree> messages = picture_messages(model, channel);
      if (messages.empty()) canvas.text(2, 2, "the last message cannot be decoded", Style::warn);
      draw_picture(canvas, messages, view.zoom, around.decode_jpeg);
      break;
    }
  }
  draw_title(canvas, model, view, around);
  draw_keys(canvas, view);
  return canvas;
}

void draw_table(Canvas& canvas, const Model& model, View& view, const Surroundings& around) {
  int numbers = 0;
  for (const ColumnPlace& place : kNumberColumns) numbers += place.width + 1;
  const int left = std::max(20, canvas.width() - numbers);
  const int name_width = std::clamp(left * 45 / 100, 10, 28);
  const auto mark = [&](Column column) {
    return std::string(view.sort == column ? (view.descending ? "▾" : "▴") : "");
  };
  canvas.text(0, 1, "CHANNEL" + mark(Column::channel), Style::bold);
  canvas.text(name_width + 1, 1, "TYPE" + mark(Column::type), Style::bold);
  int right = left;
  for (const ColumnPlace& place : kNumberColumns) {
    right += place.width + 1;
    canvas.text_right(right, 1, place.title + mark(place.column), Style::bold);
  }
  const std::vector<int> rows = visible_channels(model, view, around);
  const int count = static_cast<int>(rows.size());
  const int finding_rows = static_cast<int>(2 * around.findings.size() +
                                            std::min<std::size_t>(3, around.problems.size()));
  const int shown = std::max(1, canvas.height() - 3 - std::min(finding_rows, canvas.height() / 2));
  view.page_rows = shown;
  int selected = 0;
  for (int i = 0; i < count; ++i) {
    if (model.channels()[static_cast<std::size_t>(rows[static_cast<std::size_t>(i)])].name ==
        view.selected)
      selected = i;
  }
  const int first = first_row(selected, count, shown);
  int y = 2;
  for (int i = first; i < std::min(count, first + shown); ++i, ++y) {
    const int index = rows[static_cast<std::size_t>(i)];
    const Channel& channel = model.channels()[static_cast<std::size_t>(index)];
    canvas.text(0, y, channel.name, Style::normal, name_width);
    canvas.text(name_width + 1, y, type_text(model, channel),
                channel.candidates.empty() ? Style::warn : Style::normal, left - name_width - 2);
    right = left;
    for (const ColumnPlace& place : kNumberColumns) {
      right += place.width + 1;
      canvas.text_right(right, y, cell_text(model, index, place.column, around),
                        cell_style(model, index, place.column, around));
    }
    if (i == selected) canvas.style_row(y, Style::selected);
  }
  if (count == 0) {
    canvas.text(1, 2,
                model.channels().empty() ? "nothing heard yet" : "no channel matches the filter",
                Style::dim);
    y = 4;
  }
  draw_findings(canvas, around, std::max(y, canvas.height() - 1 - finding_rows), false);
}

void draw_channel(Canvas& canvas, const Model& model, View& view, const Surroundings& around) {
  const int index = model.find(view.selected);
  if (index < 0) {
    canvas.text(2, 2, "nothing heard on " + view.selected, Style::warn);
    return;
  }
  const Channel& channel = model.channels()[static_cast<std::size_t>(index)];
  const Rates rates = rates_of(channel, around);
  canvas.text(
      1, 1,
      type_text(model, channel) + "   " + plural(channel.rate.count(), "message") + "   " +
          short_number(rates.hz) + " Hz   " +
          plural(static_cast<int64_t>(channel.last.bytes.size()), "byte") +
          (channel.undecodable() > 0 ? "   undecodable " + std::to_string(channel.undecodable())
                                     : ""),
      Style::bold);
  lcm_schema::Tree tree;
  if (!model.decode_last(index, tree)) {
    canvas.text(2, 3,
                channel.type() < 0
                    ? "no type with this fingerprint: give its .lcm sources with --types DIR"
                    : "the last message does not fit its type",
                Style::warn);
    return;
  }
  if (channel.candidates.size() > 1) {
    std::string others = "t: also";
    for (const int type : channel.candidates) {
      if (type != channel.type())
        others += " " + model.decoder().schema().structures()[static_cast<std::size_t>(type)].name;
    }
    canvas.text_right(canvas.width() - 1, 1, others, Style::warn);
  }
  const std::vector<FieldRow> rows = field_rows(tree, channel.name, view);
  const int count = static_cast<int>(rows.size());
  const int shown = std::max(1, canvas.height() - 3);
  view.page_rows = shown;
  int selected = 0;
  for (int i = 0; i < count; ++i) {
    if (rows[static_cast<std::size_t>(i)].path == view.cursor) selected = i;
  }
  const int name_width = std::max(18, canvas.width() * 28 / 100);
  const int type_width = std::max(10, canvas.width() * 16 / 100);
  const int line_width = canvas.width() * 30 / 100;
  const int value_width = std::max(8, canvas.width() - name_width - type_width - line_width - 3);
  const int first = first_row(selected, count, shown);
  for (int i = first; i < std::min(count, first + shown); ++i) {
    const FieldRow& row = rows[static_cast<std::size_t>(i)];
    const int y = 2 + i - first;
    const char* fold = !row.foldable                                           ? "  "
                       : view.unfolded.contains(channel.name + "/" + row.path) ? "▾ "
                                                                               : "▸ ";
    canvas.text(1 + 2 * row.depth, y, fold + row.label, Style::normal,
                std::max(1, name_width - 2 * row.depth));
    canvas.text(name_width + 1, y, row.type, Style::dim, type_width);
    canvas.text(name_width + type_width + 2, y, row.value, Style::normal, value_width);
    std::vector<double> line;
    if (row.profile) {
      const lcm_schema::Node& node = tree.nodes[static_cast<std::size_t>(row.node)];
      for (int x = 0; x < line_width && node.count > 0; ++x) {
        line.push_back(tree.number(
            node, static_cast<std::size_t>(x) * node.count / static_cast<std::size_t>(line_width)));
      }
    } else if (row.numeric) {
      line = series_of(model, channel, row.path, static_cast<std::size_t>(line_width)).values;
    }
    int x = canvas.width() - line_width;
    for (const char32_t bar : sparkline(line, static_cast<std::size_t>(line_width)))
      canvas.put(x++, y, bar, row.profile ? Style::dim : Style::good);
    if (std::find(view.plotted.begin(), view.plotted.end(), row.path) != view.plotted.end())
      canvas.put(0, y, U'+', Style::warn);
    if (i == selected) canvas.style_row(y, Style::selected);
  }
}

void draw_plot(Canvas& canvas, const Model& model, const View& view) {
  static constexpr Style kStyles[] = {Style::good, Style::warn, Style::bad, Style::bold};
  const int index = model.find(view.selected);
  const int rows = canvas.height() - 4;
  if (index < 0 || rows < 2) return;
  const Channel& channel = model.channels()[static_cast<std::size_t>(index)];
  std::vector<Series> all;
  double low = INFINITY;
  double high = -INFINITY;
  for (const std::string& path : view.plotted) {
    all.push_back(
        series_of(model, channel, path, static_cast<std::size_t>(1200 / std::max(1.0, view.zoom))));
    for (const double value : all.back().values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (!(low <= high)) {
    canvas.text(2, 2, "no number to plot yet", Style::warn);
    return;
  }
  const double middle = low / 2 + high / 2;
  if (high - low < 1e-9 * std::max(1.0, std::abs(middle))) {
    low = middle - std::max(1e-6, std::abs(middle) * 1e-6);
    high = middle + std::max(1e-6, std::abs(middle) * 1e-6);
  }
  constexpr int kAxis = 12;
  const int64_t first_us = all[0].times_us.front();
  const double seconds =
      std::max(1e-3, static_cast<double>(all[0].times_us.back() - first_us) * 1e-6);
  for (std::size_t i = 0; i < all.size(); ++i) {
    DotGrid dots(canvas.width() - kAxis - 1, rows);
    double last_x = kNaN;
    double last_y = kNaN;
    for (std::size_t k = 0; k < all[i].values.size(); ++k) {
      const double part = (all[i].values[k] / 2 - low / 2) / (high / 2 - low / 2);
      const double x = (dots.width() - 1) *
                       (static_cast<double>(all[i].times_us[k] - first_us) * 1e-6) / seconds;
      const double y = (dots.height() - 1) * (1 - part);
      if (std::isfinite(y) && std::isfinite(last_y)) dots.line(last_x, last_y, x, y);
      if (std::isfinite(y))
        dots.dot(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)));
      last_x = x;
      last_y = y;
    }
    const Style style = kStyles[i % 4];
    dots.draw(canvas, kAxis + 1, 2, style);
    canvas.text(
        kAxis + 1 + static_cast<int>(i) * (canvas.width() - kAxis) / static_cast<int>(all.size()),
        1,
        "━ " + view.plotted[i] + " = " +
            (all[i].values.empty() ? "" : plain_number(all[i].values.back())),
        style);
  }
  for (int y = 2; y < 2 + rows; ++y) canvas.put(kAxis, y, U'│', Style::dim);
  for (int step = 0; step <= 4; ++step) {
    const int y = 2 + (rows - 1) * step / 4;
    canvas.text_right(kAxis, y, plain_number(high + (low - high) * step / 4), Style::dim);
    canvas.put(kAxis, y, U'┤', Style::dim);
  }
  canvas.text(kAxis + 1, canvas.height() - 2,
              "-" + plain_number(std::round(seconds * 10) / 10) + " s", Style::dim);
  canvas.text_right(canvas.width() - 1, canvas.height() - 2, "now", Style::dim);
}

namespace {

struct WhoLine {
  std::string text;
  Style style = Style::normal;
};

std::string sender_name(const Sender& sender, const Surroundings& around) {
  const auto found = around.publishers.find(sender.address);
  return (found == around.publishers.end() ? "?" : to_string(found->second)) + "  " +
         to_string(sender.address);
}

void add_sender(const Model& model,
                const Sender& sender,
                const Surroundings& around,
                std::vector<WhoLine>& lines) {
  std::string head = sender_name(sender, around) + "   " + plural(sender.messages, "message");
  if (sender.lost() > 0) head += ", lost " + std::to_string(sender.lost());
  if (sender.sequence.duplicates() > 0)
    head += ", doubled " + std::to_string(sender.sequence.duplicates());
  if (sender.sequence.restarts() > 0)
    head += ", began anew " + std::to_string(sender.sequence.restarts());
  lines.push_back({head, sender.lost() > 0 ? Style::bad : Style::bold});
  for (const Sender::Use& use : sender.uses) {
    const Channel& channel = model.channels()[static_cast<std::size_t>(use.channel)];
    const bool last = &use == &sender.uses.back();
    const Loss loss = model.loss(sender, use);
    lines.push_back({std::string(last ? "  └──▶ " : "  ├──▶ ") + channel.name + "   " +
                         short_number(rates_of(channel, around).hz) + " Hz   " +
                         std::to_string(use.count) +
                         (loss.count > 0 ? "   lost " + loss_text(loss) : ""),
                     loss.count > 0 ? Style::warn : Style::normal});
  }
}

}  // namespace

void draw_who(Canvas& canvas, const Model& model, View& view, const Surroundings& around) {
  std::vector<WhoLine> lines;
  if (around.is_log) {
    lines.push_back({"a log does not say who published", Style::dim});
  } else {
    lines.push_back({"WHO PUBLISHES", Style::title});
    for (const Sender& sender : model.senders()) {
      if (!sender.uses.empty()) add_sender(model, sender, around, lines);
    }
    if (model.senders().empty()) lines.push_back({"nobody yet", Style::dim});
    lines.push_back({"", Style::normal});
    lines.push_back({"WHO LISTENS (and what its full buffer lost since it started)", Style::title});
    for (const Listener& listener : around.listeners) {
      lines.push_back({"  " + (listener.self ? "this spy" : to_string(listener.process)) +
                           "   lost " + std::to_string(listener.drops),
                       listener.drops > 0 ? Style::bad : Style::normal});
    }
    if (model.foreign() > 0)
      lines.push_back(
          {"datagrams that are not LCM's: " + std::to_string(model.foreign()), Style::warn});
  }
  const int shown = canvas.height() - 2;
  view.page_rows = shown;
  view.scroll = std::clamp(view.scroll, 0, std::max(0, static_cast<int>(lines.size()) - shown));
  for (int y = 1; y <= shown && static_cast<std::size_t>(view.scroll + y - 1) < lines.size(); ++y) {
    const WhoLine& line = lines[static_cast<std::size_t>(view.scroll + y - 1)];
    canvas.text(1, y, line.text, line.style);
  }
}

}  // namespace marco::spy
