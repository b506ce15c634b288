#include "web/snapshot/export_html.hpp"

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "web/page/page_files.hpp"
#include "web/snapshot/bundle.hpp"
#include "web/snapshot/inline_files.hpp"
#include "web/snapshot/snapshot.hpp"

namespace marco::web {
namespace {

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at)) {
    text.replace(at, from.size(), to);
    at += to.size();
  }
}

// What stands in the page for a file of its own.
void replace_line(std::string& page, std::string_view line, const std::string& content) {
  const std::size_t at = page.find(line);
  require(at != std::string::npos, "index.html lacks " + std::string(line));
  page.replace(at, line.size(), content);
}

// The end of a script may stand in its strings only as <\/script>; the same text for JavaScript.
std::string script(const std::string& attributes, std::string content) {
  replace_all(content, "</", "<\\/");
  replace_all(content, "<!--", "<\\!--");
  return "<script" + attributes + ">" + content + "</script>";
}

}  // namespace

std::string export_html(const std::filesystem::path& folder, const std::filesystem::path& three) {
  std::string snapshot = inline_files(snapshot_json(folder), folder);
  replace_all(snapshot, "<", "\\u003c");
  std::string page(page_file("index.html").value());
  std::string scripts = script(" type=\"application/json\" id=\"snapshot\"", snapshot);
  const bool has_model = snapshot.find("\"model\":null") == std::string::npos;
  if (has_model && std::filesystem::exists(three)) {
    scripts += script(" type=\"text/plain\" id=\"three\"", files::read_whole_file(three));
  }
  scripts += script("", bundle_modules("app.js", page_file));
  replace_line(page, R"(<link rel="stylesheet" href="page/page.css">)",
               "<style>\n" + std::string(page_file("page.css").value()) + "</style>");
  replace_line(page, R"(<script type="module" src="page/app.js"></script>)", scripts);
  return page;
}

}  // namespace marco::web
