#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "lcm_tools/procman/config.hpp"
#include "lcm_tools/procman/exec_line.hpp"

// The scripts in config/: what they name is there. Tests run in the project's folder.
namespace marco::procman {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::set<std::string> known_programs() {
  std::set<std::string> names{"lcm-logger"};  // and LCM's own
  for (const char* room : {"drivers", "lcm_tools", "mapping3d", "simulator", "slam", "teleop",
                           "tools", "viewer", "web"}) {
    for (const auto& entry : fs::recursive_directory_iterator(room)) {
      if (entry.path().filename() != "CMakeLists.txt") continue;
      const std::string text = text_of(entry.path());
      for (std::size_t at = 0; (at = text.find("marco_executable(", at)) != std::string::npos;) {
        at = text.find_first_not_of(" \n", at + std::string("marco_executable(").size());
        names.insert(text.substr(at, text.find_first_of(" \n)", at) - at));
      }
    }
  }
  return names;
}

void check_commands(const GroupConfig& group, const std::set<std::string>& programs) {
  for (const CommandConfig& command : group.commands) {
    const std::vector<std::string> words = split_words(command.exec);
    ASSERT_THAT(words, testing::Not(IsEmpty()));
    const bool is_script = words[0].rfind("$MARCO_ROOT/", 0) == 0;
    EXPECT_TRUE(is_script || programs.count(words[0]) == 1) << command.id << ": " << words[0];
    for (const std::string& word : words) {
      if (word.rfind("$MARCO_ROOT/", 0) != 0) continue;
      EXPECT_TRUE(fs::exists(word.substr(12))) << command.id << ": " << word;
    }
  }
  for (const GroupConfig& inner : group.groups) check_commands(inner, programs);
}

TEST(ShippedScripts, NameCommandsProgramsAndFilesThatExist) {
  const std::set<std::string> programs = known_programs();
  ASSERT_EQ(programs.count("marco-slam"), 1U);
  int scripts = 0;
  for (const auto& entry : fs::directory_iterator("config")) {
    if (entry.path().extension() != ".procman") continue;
    SCOPED_TRACE(entry.path());
    const Config config = load_config(entry.path());
    EXPECT_THAT(find_mistakes(config), IsEmpty());
    EXPECT_THAT(find_script_mistakes(config), IsEmpty());
    check_commands(config.root, programs);
    scripts += static_cast<int>(config.scripts.size());
  }
  EXPECT_GE(scripts, 10);
}

}  // namespace
}  // namespace marco::procman
