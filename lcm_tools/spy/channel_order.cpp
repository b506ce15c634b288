// Which channels the table shows, and in which order.
#include <algorithm>
#include <cctype>

#include "lcm_tools/spy/view.hpp"

namespace marco::spy {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// "CMD_2" before "CMD_10": runs of digits by their value.
bool comes_before(const std::string& a, const std::string& b) {
  const auto digit = [](const std::string& text, std::size_t at) {
    return at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])) != 0;
  };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!digit(a, i) || !digit(b, j)) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
      continue;
    }
    while (digit(a, i + 1) && a[i] == '0') ++i;
    while (digit(b, j + 1) && b[j] == '0') ++j;
    std::size_t a_end = i, b_end = j;
    while (digit(a, a_end)) ++a_end;
    while (digit(b, b_end)) ++b_end;
    if (a_end - i != b_end - j) return a_end - i < b_end - j;
    const int order = a.compare(i, a_end - i, b, j, b_end - j);
    if (order != 0) return order < 0;
    i = a_end;
    j = b_end;
  }
  return a.size() - i < b.size() - j || (a.size() - i == b.size() - j && a < b);
}

std::string full_type_name(const Model& model, const Channel& channel) {
  if (channel.type() < 0) return "";
  return model.decoder().schema().structures()[static_cast<std::size_t>(channel.type())].name;
}

}  // namespace

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
  const std::string& name =
      model.decoder().schema().structures()[static_cast<std::size_t>(channel.type())].name;
  const std::size_t dot = name.rfind('.');
  std::string text = name.substr(dot + 1);  // the whole name where there is no dot
  const std::size_t count = channel.candidates.size();
  if (count > 1)
    text += " " + std::to_string(channel.choice % count + 1) + "/" + std::to_string(count);
  if (dot != std::string::npos) text += " (" + name.substr(0, dot) + ")";
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
    if (lower(channel.name + " " + type + " " + full_type_name(model, channel)).find(filter) ==
        std::string::npos) {
      continue;
    }
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
    return reverse ? comes_before(b.text, a.text) : comes_before(a.text, b.text);
  });
  std::vector<int> result;
  result.reserve(rows.size());
  for (const Row& row : rows) result.push_back(row.channel);
  return result;
}

}  // namespace marco::spy
