#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/spy/page_text.hpp"

namespace marco::spy {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

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

}  // namespace marco::spy
