#include <algorithm>
#include <array>

#include "tools/spy/page_text.hpp"

namespace marco::spy {
namespace {

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
  if (column == Column::age && !around.overall_rates && channel.rate.silent(around.now_us)) {
    return Style::warn;
  }
  return Style::normal;
}

}  // namespace

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
  draw_findings(canvas, around, std::max(y, canvas.height() - 1 - finding_rows),
                Problems::first_three);
}

}  // namespace marco::spy
