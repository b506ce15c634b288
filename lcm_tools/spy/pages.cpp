#include <algorithm>

#include "lcm_tools/spy/page_text.hpp"

namespace marco::spy {
namespace {

// What happens to the log stands before its name: a long path is cut, not the state.
std::string log_state(const Surroundings& around) {
  if (!around.is_log || around.overall_rates) return "";
  return (around.log_ended ? "end of the log" : "x" + plain_number(around.speed)) + "  ";
}

void draw_title(Canvas& canvas, const Model& model, const View& view, const Surroundings& around) {
  std::string text = " marco-spy  " + log_state(around);
  if (view.page != Page::table && view.page != Page::who && view.page != Page::help)
    text += view.selected + "  ";
  text += around.source;
  const double seconds = static_cast<double>(model.last_us() - model.first_us()) * 1e-6;
  std::string right = plural(static_cast<int64_t>(model.channels().size()), "channel") + "  " +
                      plural(model.messages(), "message");
  if (model.messages() > 0) right += "  " + age_text(seconds);
  if (model.lost() > 0) right += "  lost " + std::to_string(model.lost());
  canvas.text(0, 0, text, Style::normal, canvas.width() - 3 - static_cast<int>(right.size()));
  canvas.text_right(canvas.width() - 1, 0, "  " + right);
  canvas.style_row(0, Style::title);
  if (view.paused) canvas.text(canvas.width() / 2 - 4, 0, " PAUSED ", Style::warn);
}

std::string keys_of(Page page) {
  switch (page) {
    case Page::table:
      return "Enter open  s sort  r reverse  / filter  p pause  w who  x stop  ? help  q quit";
    case Page::channel:
      return "Enter fold  v draw  g plot  + add to plot  t type  p pause  Esc back  q quit";
    case Page::plot:
    case Page::picture:
      return "+ - zoom  p pause  Esc back  q quit";
    case Page::who:
    case Page::help:
      return "Esc back  q quit";
  }
  return "";
}

void draw_keys(Canvas& canvas, const View& view, const Surroundings& around) {
  const int y = canvas.height() - 1;
  if (view.asks_release) {
    canvas.text(0, y, "Release the emergency stop? Robots may then move.  y yes, other keys no",
                Style::bad);
    return;
  }
  if (view.typing_filter) {
    canvas.text(0, y, "filter: " + view.filter + "_   (Enter keeps it, Esc drops it)", Style::warn);
    return;
  }
  if (around.emergency && around.emergency->engaged) {
    const std::string release = around.is_log ? "" : "  X release  q quit";
    canvas.text_right(canvas.width(), y, release, Style::bold);
    std::string text = "EMERGENCY STOP by " + around.emergency->sender;
    if (!around.emergency->reason.empty()) text += ": " + around.emergency->reason;
    canvas.text(0, y, text, Style::bad, canvas.width() - static_cast<int>(release.size()));
    return;
  }
  canvas.text(0, y, keys_of(view.page), Style::dim);
  if (!view.filter.empty() && view.page == Page::table) {
    canvas.text_right(canvas.width() - 1, y, "  filter: " + view.filter, Style::warn);
  }
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
      "HZ       messages a second over the last 2 s or more (--once: all received)",
      "JITTER   longest minus shortest interval in that time",
      "B/S      bytes a second      AGE  since the last message",
      "UNDEC    messages of no known type, damaged, or without a type",
      "LOST     messages that never arrived: gaps in the senders' numbers, fragments;",
      "         ~ for a sender of several channels, divided by their rates",
      "",
      "Enter    opens a channel; folds and unfolds a field     Esc  goes back",
      "s r /    sort by the next column, reverse, filter by name or type",
      "v g +    draw the scan, grid or image; plot a field; add one to the plot",
      "+ -      zoom in a picture or plot",
      "t        the next type with the same fingerprint",
      "p        pause (space too)      c  forget all and count again",
      "w        publishers, listeners, losses",
      "x        stops every robot: EMERGENCY_STOP       X  releases it, after asking"};
  int y = 2;
  for (const char* line : kLines) canvas.text(2, y++, line);
  draw_findings(canvas, around, y + 1, Problems::all);
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
      draw_picture(canvas, messages, view.zoom);
      break;
    }
  }
  draw_title(canvas, model, view, around);
  draw_keys(canvas, view, around);
  return canvas;
}

}  // namespace marco::spy
