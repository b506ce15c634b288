#include <algorithm>

#include "lcm_tools/spy/page_text.hpp"

namespace marco::spy {
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
    head += ", restarted " + std::to_string(sender.sequence.restarts());
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
    lines.push_back(
        {"WHO LISTENS (with messages lost in its full buffer since the start)", Style::title});
    for (const Listener& listener : around.listeners) {
      lines.push_back({"  " + (listener.self ? "this spy" : to_string(listener.process)) +
                           "   lost " + std::to_string(listener.drops),
                       listener.drops > 0 ? Style::bad : Style::normal});
    }
    if (model.foreign() > 0)
      lines.push_back(
          {"datagrams other than LCM's: " + std::to_string(model.foreign()), Style::warn});
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
