#include <algorithm>
#include <array>

#include "lcm_tools/spy/page_text.hpp"

namespace marco::spy {
namespace {

struct ColumnPlace {
  Column column;
  const char* title;
  int width;
};

// As narrow as their contents, so that they fit into 80 cells with the names.
constexpr std::array<ColumnPlace, 7> kNumberColumns = {{{Column::count, "COUNT", 7},
                                                        {Column::hz, "HZ", 5},
                                                        {Column::jitter, "JITTER", 8},
                                                        {Column::bandwidth, "B/S", 5},
                                                        {Column::age, "AGE", 6},
                                                        {Column::undecodable, "UNDEC", 6},
                                                        {Column::lost, "LOST", 6}}};

// As wide as the longest name, but so that a type's own name has room.
int name_column(const Model& model, const std::vector<int>& rows, int left) {
  constexpr int kTypeWidth = 15;
  std::size_t longest = 10;
  for (const int row : rows) {
    longest = std::max(longest, model.channels()[static_cast<std::size_t>(row)].name.size());
  }
  return std::min(static_cast<int>(std::min<std::size_t>(longest, 28)),
                  std::max(10, left - kTypeWidth));
}

std::string cell_text(const Model& model, int index, Column column, const Surroundings& around) {
  const Channel& channel = model.channels()[static_cast<std::size_t>(index)];
  const Rates rates = rates_of(channel, around);
  switch (column) {
    case Column::count:
      return channel.rate.count() < 10'000'000
                 ? std::to_string(channel.rate.count())
                 : short_number(static_cast<double>(channel.rate.count()));
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

// @returns the row behind.
int draw_emptiness(Canvas& canvas, const Model& model, const Surroundings& around) {
  if (!model.channels().empty()) {
    canvas.text(1, 2, "no channel matches the filter (Esc drops it)", Style::dim);
    return 4;
  }
  if (around.is_log) {
    canvas.text(1, 2, around.log_ended ? "the log holds no message" : "nothing read yet",
                Style::dim);
    return 4;
  }
  canvas.text(1, 2, "no messages yet", Style::dim);
  int y = 4;
  for (const std::string& line : around.hints) canvas.text(1, y++, line);
  return y + 1;
}

}  // namespace

void draw_table(Canvas& canvas, const Model& model, View& view, const Surroundings& around) {
  int numbers = 0;
  for (const ColumnPlace& place : kNumberColumns) numbers += place.width + 1;
  const int left = std::max(20, canvas.width() - numbers);
  const std::vector<int> rows = visible_channels(model, view, around);
  const int name_width = name_column(model, rows, left);
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
  const int count = static_cast<int>(rows.size());
  const int finding_rows = rows_of_findings(around, canvas.width(), Problems::first_three);
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
  if (count == 0) y = draw_emptiness(canvas, model, around);
  draw_findings(canvas, around, std::max(y, canvas.height() - 1 - finding_rows),
                Problems::first_three);
}

}  // namespace marco::spy
