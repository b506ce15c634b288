#include <algorithm>
#include <cmath>
#include <limits>

#include "lcm_tools/spy/page_text.hpp"

namespace marco::spy {
namespace {

// Type, rates and the other types it could be.
void draw_head(Canvas& canvas,
               const Model& model,
               const Channel& channel,
               const Surroundings& around) {
  std::string head = type_text(model, channel);
  head += "   " + plural(channel.rate.count(), "message");
  head += "   " + short_number(rates_of(channel, around).hz) + " Hz";
  head += "   " + plural(static_cast<int64_t>(channel.last.bytes.size()), "byte");
  if (channel.undecodable() > 0) head += "   undecodable " + std::to_string(channel.undecodable());
  canvas.text(1, 1, head, Style::bold);
  if (channel.candidates.size() < 2) return;
  std::string others = "t: also";
  for (const int type : channel.candidates) {
    if (type == channel.type()) continue;
    others += ' ';
    others += model.decoder().schema().structures()[static_cast<std::size_t>(type)].name;
  }
  canvas.text_right(canvas.width() - 1, 1, others, Style::warn);
}

struct Widths {
  explicit Widths(int width)
      : name(std::max(18, width * 28 / 100)),
        type(std::max(10, width * 16 / 100)),
        line(width * 30 / 100),
        value(std::max(8, width - name - type - line - 3)) {}
  int name;
  int type;
  int line;
  int value;
};

// What a row's sparkline shows: an array itself, or a number's history.
std::vector<double> line_of(const Model& model,
                            const Channel& channel,
                            const lcm_schema::Tree& tree,
                            const FieldRow& row,
                            std::size_t width) {
  std::vector<double> line;
  if (row.numeric) line = series_of(model, channel, row.path, width).values;
  if (!row.profile) return line;
  const lcm_schema::Node& node = tree.nodes[static_cast<std::size_t>(row.node)];
  line.reserve(width);
  for (std::size_t x = 0; x < width && node.count > 0; ++x) {
    line.push_back(tree.number(node, x * node.count / width));
  }
  return line;
}

void draw_row(Canvas& canvas, const View& view, const FieldRow& row, int y) {
  const Widths widths(canvas.width());
  std::string label = "  ";
  if (row.foldable) label = view.unfolded.contains(view.selected + "/" + row.path) ? "▾ " : "▸ ";
  label += row.label;
  canvas.text(1 + 2 * row.depth, y, label, Style::normal, std::max(1, widths.name - 2 * row.depth));
  canvas.text(widths.name + 1, y, row.type, Style::dim, widths.type);
  canvas.text(widths.name + widths.type + 2, y, row.value, Style::normal, widths.value);
  if (std::find(view.plotted.begin(), view.plotted.end(), row.path) != view.plotted.end()) {
    canvas.put(0, y, U'+', Style::warn);
  }
}

struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void widen(const Series& series) {
    for (const double value : series.values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  // A constant is drawn in the middle of a little room.
  void make_room() {
    const double middle = low / 2 + high / 2;
    if (high - low >= 1e-9 * std::max(1.0, std::abs(middle))) return;
    const double room = std::max(1e-6, std::abs(middle) * 1e-6);
    low = middle - room;
    high = middle + room;
  }
  // 0 at the bottom, 1 at the top; halves first, since the difference may overflow.
  double part(double value) const { return (value / 2 - low / 2) / (high / 2 - low / 2); }
};

constexpr int kAxisCells = 12;

void draw_curve(Canvas& canvas, const Series& series, const Span& span, Style style) {
  DotGrid dots(canvas.width() - kAxisCells - 1, canvas.height() - 4);
  const int64_t first_us = series.times_us.front();
  const double all_us = std::max(1000.0, static_cast<double>(series.times_us.back() - first_us));
  double last_x = std::numeric_limits<double>::quiet_NaN();
  double last_y = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < series.values.size(); ++k) {
    const double x =
        (dots.width() - 1) * static_cast<double>(series.times_us[k] - first_us) / all_us;
    const double y = (dots.height() - 1) * (1 - span.part(series.values[k]));
    if (std::isfinite(y))
      dots.line(std::isfinite(last_y) ? last_x : x, std::isfinite(last_y) ? last_y : y, x, y);
    last_x = x;
    last_y = y;
  }
  dots.draw(canvas, kAxisCells + 1, 2, style);
}

void draw_axes(Canvas& canvas, const Span& span, double seconds) {
  const int rows = canvas.height() - 4;
  for (int y = 2; y < 2 + rows; ++y) canvas.put(kAxisCells, y, U'│', Style::dim);
  for (int step = 0; step <= 4; ++step) {
    const int y = 2 + (rows - 1) * step / 4;
    const double value = span.high * (4 - step) / 4 + span.low * step / 4;
    canvas.text_right(kAxisCells, y, plain_number(value), Style::dim);
    canvas.put(kAxisCells, y, U'┤', Style::dim);
  }
  const std::string begin = plain_number(std::round(seconds * 10) / 10);
  canvas.text(kAxisCells + 1, canvas.height() - 2, "-" + begin + " s", Style::dim);
  canvas.text_right(canvas.width() - 1, canvas.height() - 2, "now", Style::dim);
}

}  // namespace

void draw_channel(Canvas& canvas, const Model& model, View& view, const Surroundings& around) {
  const int index = model.find(view.selected);
  if (index < 0) {
    canvas.text(2, 2, "no messages on " + view.selected, Style::warn);
    return;
  }
  const Channel& channel = model.channels()[static_cast<std::size_t>(index)];
  draw_head(canvas, model, channel, around);
  lcm_schema::Tree tree;
  if (!model.decode_last(index, tree)) {
    canvas.text(2, 3,
                channel.type() < 0
                    ? "no type with this fingerprint: give its .lcm sources with --types DIR"
                    : "the last message does not fit its type",
                Style::warn);
    return;
  }
  const std::vector<FieldRow> rows = field_rows(tree, channel.name, view);
  const auto cursor = std::find_if(rows.begin(), rows.end(),
                                   [&](const FieldRow& row) { return row.path == view.cursor; });
  const int selected = cursor == rows.end() ? 0 : static_cast<int>(cursor - rows.begin());
  const int count = static_cast<int>(rows.size());
  const int shown = std::max(1, canvas.height() - 3);
  view.page_rows = shown;
  const int line_width = Widths(canvas.width()).line;
  const int first = first_row(selected, count, shown);
  for (int i = first; i < std::min(count, first + shown); ++i) {
    const FieldRow& row = rows[static_cast<std::size_t>(i)];
    const int y = 2 + i - first;
    draw_row(canvas, view, row, y);
    const auto width = static_cast<std::size_t>(line_width);
    int x = canvas.width() - line_width;
    for (const char32_t bar : sparkline(line_of(model, channel, tree, row, width), width)) {
      canvas.put(x++, y, bar, row.profile ? Style::dim : Style::good);
    }
    if (i == selected) canvas.style_row(y, Style::selected);
  }
}

void draw_plot(Canvas& canvas, const Model& model, const View& view) {
  static constexpr Style kStyles[] = {Style::good, Style::warn, Style::bad, Style::bold};
  const int index = model.find(view.selected);
  if (index < 0 || canvas.height() < 6) return;
  const Channel& channel = model.channels()[static_cast<std::size_t>(index)];
  const auto limit = static_cast<std::size_t>(1200 / std::max(1.0, view.zoom));
  std::vector<Series> all;
  Span span;
  for (const std::string& path : view.plotted) {
    all.push_back(series_of(model, channel, path, limit));
    span.widen(all.back());
  }
  if (!(span.low <= span.high)) {
    canvas.text(2, 2, "no number to plot yet", Style::warn);
    return;
  }
  span.make_room();
  const int step = (canvas.width() - kAxisCells) / static_cast<int>(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    draw_curve(canvas, all[i], span, kStyles[i % 4]);
    std::string legend = "━ " + view.plotted[i];
    legend += " = " + plain_number(all[i].values.back());
    canvas.text(kAxisCells + 1 + static_cast<int>(i) * step, 1, legend, kStyles[i % 4], step);
  }
  const auto& times_us = all[0].times_us;
  draw_axes(canvas, span, static_cast<double>(times_us.back() - times_us.front()) * 1e-6);
}

}  // namespace marco::spy
