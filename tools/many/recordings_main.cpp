#include <algorithm>
#include <fstream>
#include <iterator>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "recordings/recording.hpp"
#include "recordings/recording_folder.hpp"

namespace marco {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHelp =
    R"(Prints the recordings that INPUTs are or hold, one a line: the paths of its parts, tabs between them.

INPUT: a recording; a folder, also with folders in it; or a text file with one recording per line (paths relative to that file,
# begins a comment).)";

std::vector<fs::path> listed(const fs::path& list) {
  std::vector<fs::path> found;
  std::ifstream file = files::open_readable(list);
  for (std::string line; std::getline(file, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    const fs::path path = list.parent_path() / line;
    require(fs::exists(path), list.string() + ": there is no " + path.string());
    found.push_back(fs::canonical(path));
  }
  return found;
}

std::vector<RecordingParts> find_recordings(const std::vector<std::string>& inputs) {
  std::vector<fs::path> named;
  std::vector<RecordingParts> found;
  for (const fs::path input : inputs) {
    require(fs::exists(input), input.string() + ": is missing");
    const std::size_t before = named.size() + found.size();
    if (fs::is_directory(input)) {
      std::vector<RecordingParts> inside = recordings_in(fs::canonical(input));
      std::move(inside.begin(), inside.end(), std::back_inserter(found));
    } else if (is_recording(input)) {
      named.push_back(fs::canonical(input));
    } else {
      std::vector<fs::path> lines = listed(input);
      std::move(lines.begin(), lines.end(), std::back_inserter(named));
    }
    require(named.size() + found.size() > before,
            input.string() + ": contains neither a recording nor a list of recordings");
  }
  for (RecordingParts& parts : recordings_of(named)) found.push_back(std::move(parts));
  return found;
}

void print_recordings(const std::vector<std::string>& inputs) {
  for (const RecordingParts& parts : find_recordings(inputs)) {
    const char* before = "";
    for (const fs::path& part : parts) {
      std::printf("%s%s", before, part.c_str());
      before = "\t";
    }
    std::printf("\n");
  }
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco-recordings", [&] {
    std::vector<std::string> inputs;
    marco::process::CommandLine app(marco::kHelp, "marco-recordings");
    app.add_option("INPUT", inputs, "recordings, folders or lists").required();
    if (const auto code = app.parse(argc, argv)) return *code;
    marco::print_recordings(inputs);
    return marco::process::kExitDone;
  });
}
