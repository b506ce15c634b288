// Replays the inputs that fuzzing found worth keeping, through the same targets: whatever once
// crashed, hung or broke a promise is among them, named regression_*.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

namespace fs = std::filesystem;

Bytes read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class Corpus : public ::testing::TestWithParam<Target> {};

TEST_P(Corpus, IsTaken) {
  const fs::path folder = fs::path("tests/fuzz/corpus") / GetParam().name;
  int inputs = 0;
  std::vector<fs::path> files;
  if (fs::exists(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  }
  for (const fs::path& file : files) {
    const Bytes bytes = read(file);
    const auto begin = std::chrono::steady_clock::now();
    try {
      GetParam().run(bytes);
    } catch (const char* promise) {
      ADD_FAILURE() << file << ": broken: " << promise;
    } catch (const std::exception& error) {
      ADD_FAILURE() << file << ": " << error.what();
    }
    const auto took = std::chrono::steady_clock::now() - begin;
    // libFuzzer allows a second in a sanitized build; ten here are a hang on any machine.
    EXPECT_LT(took, std::chrono::seconds(10)) << file;
    ++inputs;
  }
  EXPECT_GT(inputs, 0) << "no corpus in " << folder;
  GetParam().run({});
}

INSTANTIATE_TEST_SUITE_P(Every, Corpus, ::testing::ValuesIn(targets()), [](const auto& target) {
  return std::string(target.param.name);
});

TEST(Corpus, AFolderForEachTargetAndNoOther) {
  for (const auto& entry : fs::directory_iterator("tests/fuzz/corpus")) {
    const std::string name = entry.path().filename();
    const bool known = std::any_of(targets().begin(), targets().end(),
                                   [&](const Target& target) { return name == target.name; });
    EXPECT_TRUE(known) << name << " is no target";
  }
}

}  // namespace
}  // namespace marco::fuzz
