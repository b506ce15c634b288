#include "tools/many/table.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "lcm_tools/files/whole_file.hpp"

namespace marco::many {
namespace {

using nlohmann::json;

json read_json(const std::filesystem::path& path) {
  return json::parse(files::read_whole_file(path), nullptr, false);
}

std::string fixed(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char letter : text) quoted += letter == '"' ? "\"\"" : std::string(1, letter);
  return quoted + "\"";
}

std::string html_text(const std::string& text) {
  std::string safe;
  for (const char letter : text) {
    switch (letter) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += letter;
    }
  }
  return safe;
}

void read_report(const json& report, Row& row) {
  for (const json& input : report.value("inputs", json::array())) {
    row.format += (row.format.empty() ? "" : ", ") + input.value("format", "");
  }
  row.scans = report.value("scans", json::object()).value("posed", int64_t{0});
  row.length_m = report.value("distance_m", 0.0);
  for (const json& loop : report.value("loops", json::array())) {
    row.loops += loop.value("in_force", false) ? 1 : 0;
  }
  row.verdict = report.value("verdict", "none");
  row.cpu_s = report.value("cpu_s", 0.0);
}

constexpr const char* kPage = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Maps</title><style>
body { font: 15px sans-serif; margin: 2em; }
table { border-collapse: collapse; }
th, td { border-bottom: 1px solid #ccc; padding: 4px 10px; text-align: left; vertical-align: middle; }
td.n { text-align: right; }
img { max-width: 200px; max-height: 120px; }
.good { color: #060; } .doubtful { color: #a60; } .wrong, .failed { color: #b00; }
</style></head><body>
)";

}  // namespace

Row row_of(const Store& store, const Entry& entry) {
  Row row;
  row.name = entry.name;
  for (const auto& part : entry.parts) row.path += (row.path.empty() ? "" : "; ") + part.string();
  row.verdict = "not done";
  if (std::filesystem::exists(store.report(entry))) {
    read_report(read_json(store.report(entry)), row);
    row.has_picture = std::filesystem::exists(store.results(entry) / "map.png");
  } else if (std::filesystem::exists(store.failure(entry))) {
    const json failure = read_json(store.failure(entry));
    row.verdict = "failed";
    row.reason = failure.value("message", "");
    row.cpu_s = failure.value("cpu_s", 0.0);
  }
  return row;
}

std::string csv_of(const std::vector<Row>& rows) {
  std::string text = "log,format,scans,length_m,loops,verdict,cpu_s,picture,reason,path\r\n";
  for (const Row& row : rows) {
    const std::string picture = row.has_picture ? row.name + "/map.png" : "";
    for (const std::string& field :
         {row.name, row.format, std::to_string(row.scans), fixed(row.length_m, 2),
          std::to_string(row.loops), row.verdict, fixed(row.cpu_s, 2), picture, row.reason}) {
      text += csv_field(field) + ",";
    }
    text += csv_field(row.path) + "\r\n";
  }
  return text;
}

std::string html_of(const std::vector<Row>& rows) {
  const auto count = [&](const char* verdict) {
    return std::to_string(std::count_if(rows.begin(), rows.end(),
                                        [&](const Row& row) { return row.verdict == verdict; }));
  };
  std::string text = kPage;
  text += "<p>" + std::to_string(rows.size()) + " recordings";
  for (const char* verdict : {"good", "doubtful", "wrong", "failed", "not done"}) {
    text += ", " + count(verdict) + " " + verdict;
  }
  text +=
      "</p>\n<table><tr><th>log<th>format<th>scans<th>length, m<th>loops<th>verdict<th>CPU, "
      "s<th>map</tr>\n";
  for (const Row& row : rows) {
    const std::string name = html_text(row.name), verdict = html_text(row.verdict);
    const std::string log =
        row.verdict == "failed" ? "jobs/" + name + ".log" : name + "/report.json";
    text += "<tr><td title=\"" + html_text(row.path) + "\"><a href=\"" + log + "\">" + name +
            "</a><td>" + html_text(row.format) + "<td class=n>" + std::to_string(row.scans) +
            "<td class=n>" + fixed(row.length_m, 1) + "<td class=n>" + std::to_string(row.loops) +
            "<td class=\"" + verdict + "\">" + verdict +
            (row.reason.empty() ? "" : ": " + html_text(row.reason)) + "<td class=n>" +
            fixed(row.cpu_s, 1) + "<td>";
    if (row.has_picture) {
      text += "<a href=\"" + name + "/map.png\"><img loading=lazy alt=\"map\" src=\"" + name +
              "/map.png\"></a>";
    }
    text += "</tr>\n";
  }
  return text + "</table></body></html>\n";
}

std::vector<Row> write_table(const Store& store, const std::vector<Entry>& entries) {
  std::vector<Row> rows;
  rows.reserve(entries.size());
  for (const Entry& entry : entries) rows.push_back(row_of(store, entry));
  files::write_whole_file(store.out / "table.csv", csv_of(rows));
  files::write_whole_file(store.out / "index.html", html_of(rows));
  return rows;
}

}  // namespace marco::many
