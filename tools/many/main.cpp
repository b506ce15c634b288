#include <algorithm>
#include <cstdio>
#include <thread>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "tools/many/pool.hpp"
#include "tools/many/slurm.hpp"
#include "tools/many/table.hpp"

namespace marco::many {
namespace {

constexpr const char* kHelp =
    R"(Maps many recordings, each once: marco map --many DIR|LIST... --out OUT [--jobs N] [-- OPTIONS OF marco map]

DIR: every recording in it and in its folders; LIST: a text file with one recording per line. The parts of a split ROS recording
(NAME_0.bag, NAME_1.bag, ...) are one. OUT/NAME gets the results of each, as `marco map` writes them; OUT/index.html and
OUT/table.csv list all: log, format, scans, length, loops, verdict, CPU, picture. After an interruption the same command
continues, and repeats nothing. A recording that cannot be mapped is in the table with the reason; delete
OUT/jobs/NAME.json to retry it.
Exit code: 0 all were mapped, 1 some could not be.)";

struct Arguments {
  std::vector<std::string> inputs;
  std::string out = "out";
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  bool slurm = false;
  bool only_table = false;
  std::size_t task = 0;
  std::vector<std::string> for_map;  // behind --
};

std::optional<int> parse(int argc, char** argv, Arguments& arguments) {
  process::CommandLine app(kHelp, "marco-map-many");
  const auto end = std::find(argv, argv + argc, std::string("--"));
  if (end != argv + argc) arguments.for_map.assign(end + 1, argv + argc);
  app.add_option("INPUT", arguments.inputs, "folders, lists or recordings");
  app.add_option("--out", arguments.out, "folder for all results").shows_default();
  app.add_option("--jobs", arguments.jobs, "maps at a time (default: the number of processors)")
      .between(1, 10000);
  app.add_flag("--slurm", arguments.slurm, "submit them to Slurm as an array job, and return");
  app.add_flag("--table", arguments.only_table, "only write the table of existing results");
  app.add_option("--task", arguments.task, "only map the Nth of OUT/jobs/list.tsv");
  return app.parse(static_cast<int>(end - argv), argv);
}

// What the maps of a folder were made with: others would not be comparable.
void keep_options(const Store& store, const std::vector<std::string>& for_map) {
  std::string text;
  for (const std::string& word : for_map) text += quoted(word) + "\n";
  const auto path = store.jobs() / "options";
  if (!std::filesystem::exists(path)) return files::write_whole_file(path, text);
  require(files::read_whole_file(path) == text,
          store.out.string() + ": its maps were made with other options of marco map (" +
              path.string() + "); choose another --out");
}

std::vector<Entry> entries_of(const Store& store, const Arguments& arguments) {
  std::vector<Entry> entries = with_names(
      read_list(store.list()), find_recordings({arguments.inputs.begin(), arguments.inputs.end()}));
  require(!entries.empty(), "name recordings, a folder of them, or a list");
  return entries;
}

int print_table(const Store& store, const std::vector<Entry>& entries) {
  const std::vector<Row> rows = write_table(store, entries);
  std::map<std::string, int> counts;
  for (const Row& row : rows) ++counts[row.verdict];
  std::string text;
  for (const auto& [verdict, count] : counts) {
    text += ", " + std::to_string(count) + " " + verdict;
  }
  print(stdout, "%zu recordings%s; the table is in %s\n", rows.size(), text.c_str(),
        (store.out / "index.html").c_str());
  return counts.contains("failed") || counts.contains("not done") ? process::kExitFailed
                                                                  : process::kExitDone;
}

int run_task(const Store& store, const Arguments& arguments) {
  const std::vector<Entry> entries = read_list(store.list());
  require(arguments.task <= entries.size(),
          store.list().string() + ": has no line " + std::to_string(arguments.task));
  const JobEnd end = run_job(store, entries[arguments.task - 1], arguments.for_map);
  return end == JobEnd::done ? process::kExitDone : process::kExitFailed;
}

int run(const Arguments& arguments) {
  const Store store{std::filesystem::absolute(arguments.out)};
  if (arguments.task > 0) return run_task(store, arguments);
  if (arguments.only_table) return print_table(store, read_list(store.list()));
  process::catch_interrupts("the same command continues");
  const std::vector<Entry> entries = entries_of(store, arguments);
  std::filesystem::create_directories(store.jobs());
  keep_options(store, arguments.for_map);
  write_list(store.list(), entries);
  std::vector<std::string> command = {"--out", store.out.string(), "--"};
  command.insert(command.end(), arguments.for_map.begin(), arguments.for_map.end());
  if (arguments.slurm) {
    print(stdout, "%s\n", submit(store, entries, arguments.jobs, command).c_str());
    return process::kExitDone;
  }
  run_jobs(store, entries, arguments.jobs, command);
  process::end_if_interrupted();
  return print_table(store, entries);
}

}  // namespace
}  // namespace marco::many

int main(int argc, char** argv) {
  return marco::process::run_main("marco-map-many", [&] {
    marco::many::Arguments arguments;
    if (const auto code = marco::many::parse(argc, argv, arguments)) return *code;
    return marco::many::run(arguments);
  });
}
