#include "tools/many/slurm.hpp"

#include <array>
#include <cstdio>
#include <stdexcept>

#include "lcm_tools/files/whole_file.hpp"
#include "tools/many/child.hpp"

namespace marco::many {
namespace {

// The number of the job that sbatch --parsable prints, "4711" or "4711;cluster".
std::string submitted(const std::string& arguments) {
  std::FILE* pipe = popen(("sbatch --parsable " + arguments).c_str(), "r");
  std::string text;
  std::array<char, 256> block{};
  while (pipe != nullptr && std::fgets(block.data(), block.size(), pipe) != nullptr) {
    text += block.data();
  }
  const std::string number = text.substr(0, text.find_first_not_of("0123456789"));
  if (pipe == nullptr || pclose(pipe) != 0 || number.empty()) {
    throw std::runtime_error("sbatch did not accept the job (apt-get install slurm-client)");
  }
  return number;
}

std::string script_of(const std::vector<std::string>& options, const std::string& task) {
  std::string text = "#!/bin/bash\n";
  for (const std::string& option : options) text += "#SBATCH " + option + "\n";
  return text + "exec " + task + "\n";
}

}  // namespace

std::string array_of(const std::vector<std::size_t>& numbers) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    text += (text.empty() ? "" : ",") + std::to_string(numbers[i]);
    if (last > i) text += "-" + std::to_string(numbers[last]);
    i = last + 1;
  }
  return text;
}

std::string quoted(const std::string& word) {
  std::string safe = "'";
  for (const char letter : word) safe += letter == '\'' ? "'\\''" : std::string(1, letter);
  return safe + "'";
}

std::string submit(const Store& store,
                   const std::vector<Entry>& entries,
                   int jobs,
                   const std::vector<std::string>& command) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (!is_done(store, entries[i])) numbers.push_back(i + 1);
  }
  const std::string program = quoted(sibling_path("marco-map-many").string());
  std::string words;
  for (const std::string& word : command) words += " " + quoted(word);
  const auto array_script = store.jobs() / "array.sbatch",
             table_script = store.jobs() / "table.sbatch";
  // A relative pattern of names: Slurm would read % in a folder's own name.
  const std::vector<std::string> options = {"--job-name=marco-map", "--cpus-per-task=1",
                                            "--requeue", "--open-mode=append",
                                            "--output=slurm_%a.log"};
  files::write_whole_file(array_script,
                          script_of(options, program + " --task \"$SLURM_ARRAY_TASK_ID\"" + words));
  files::write_whole_file(table_script,
                          script_of({"--job-name=marco-table", "--output=slurm_table.log"},
                                    program + " --table --out " + quoted(store.out.string())));
  const std::string where = "--chdir=" + quoted(store.jobs().string()) + " ";
  std::string after;
  std::string said = "nothing left to do; ";
  if (!numbers.empty()) {
    const std::string id = submitted(where + "--array=" + array_of(numbers) + "%" +
                                     std::to_string(jobs) + " " + quoted(array_script.string()));
    after = "--dependency=afterany:" + id + " ";
    said = std::to_string(numbers.size()) + " tasks of job " + id + "; ";
  }
  const std::string id = submitted(where + after + quoted(table_script.string()));
  return said + "job " + id + " writes the table to " + (store.out / "index.html").string();
}

}  // namespace marco::many
