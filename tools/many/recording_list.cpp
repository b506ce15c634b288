#include "tools/many/recording_list.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <stdexcept>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "recordings/recording.hpp"
#include "recordings/recording_folder.hpp"

namespace marco::many {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> listed(const fs::path& list) {
  std::vector<fs::path> found;
  std::ifstream file = files::open_readable(list);
  for (std::string line; std::getline(file, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    const fs::path path = fs::path(line).is_absolute() ? fs::path(line) : list.parent_path() / line;
    require(fs::exists(path), list.string() + ": there is no " + path.string());
    found.push_back(path);
  }
  return found;
}

[[noreturn]] void throw_nothing_in(const fs::path& argument) {
  throw std::invalid_argument(argument.string() +
                              ": contains neither a recording nor a list of recordings");
}

// What can be a folder's name, and a word of a shell.
std::string plain_name(const RecordingParts& parts) {
  std::string name = parts.front().stem().string();
  while (name.ends_with(".bag") || name.ends_with(".mcap") || name.ends_with(".db3")) {
    name.resize(name.rfind('.'));
  }
  const std::size_t letters = name.find_last_not_of("0123456789_");
  if (parts.size() > 1 && letters != std::string::npos) name.resize(letters + 1);
  for (char& letter : name) {
    const auto byte = static_cast<unsigned char>(letter);
    if (std::isalnum(byte) == 0 && letter != '-' && letter != '.') letter = '_';
  }
  if (name.empty() || name.front() == '.') name = "log" + name;
  return name == "jobs" ? "jobs_log" : name;
}

}  // namespace

std::vector<RecordingParts> find_recordings(const std::vector<fs::path>& arguments) {
  std::vector<fs::path> named;
  std::vector<RecordingParts> found;
  for (const fs::path& argument : arguments) {
    require(fs::exists(argument), argument.string() + ": is missing");
    std::vector<fs::path> listed_here;
    if (fs::is_directory(argument)) {
      std::vector<RecordingParts> inside = recordings_in(fs::canonical(argument));
      if (inside.empty()) throw_nothing_in(argument);
      std::move(inside.begin(), inside.end(), std::back_inserter(found));
    } else if (is_recording(argument)) {
      named.push_back(fs::canonical(argument));
    } else {
      const std::vector<fs::path> lines = listed(argument);
      if (lines.empty()) throw_nothing_in(argument);
      for (const fs::path& path : lines) named.push_back(fs::canonical(path));
    }
  }
  for (RecordingParts& parts : recordings_of(named)) found.push_back(std::move(parts));
  return found;
}

std::vector<Entry> with_names(std::vector<Entry> earlier,
                              const std::vector<RecordingParts>& recordings) {
  std::set<std::string> names;
  std::set<fs::path> known;
  for (const Entry& entry : earlier) {
    names.insert(entry.name);
    known.insert(entry.parts.begin(), entry.parts.end());
  }
  for (const RecordingParts& parts : recordings) {
    const bool is_known = std::any_of(parts.begin(), parts.end(),
                                      [&](const fs::path& part) { return known.contains(part); });
    if (is_known) continue;
    known.insert(parts.begin(), parts.end());
    const std::string plain = plain_name(parts);
    std::string name = plain;
    for (int i = 2; !names.insert(name).second; ++i) name = plain + "_" + std::to_string(i);
    earlier.push_back({name, parts});
  }
  return earlier;
}

std::vector<Entry> read_list(const fs::path& file) {
  std::vector<Entry> entries;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    Entry entry;
    std::getline(words, entry.name, '\t');
    for (std::string path; std::getline(words, path, '\t');) entry.parts.emplace_back(path);
    if (!entry.parts.empty()) entries.push_back(std::move(entry));
  }
  return entries;
}

void write_list(const fs::path& file, const std::vector<Entry>& entries) {
  std::string text;
  for (const Entry& entry : entries) {
    text += entry.name;
    for (const fs::path& part : entry.parts) text += "\t" + part.string();
    text += "\n";
  }
  files::write_whole_file(file, text);
}

}  // namespace marco::many
