#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::testing {

/// Base of tests that run our programs in a folder of their own.
class CommandTest : public ::testing::Test {
 protected:
  struct Result {
    int code = 0;
    std::string output;  ///< both streams
  };
  Result run(const std::string& program,
             const std::vector<std::string>& arguments,
             double seconds = 600) const {
    Program started(program, arguments, at("output"));
    const int code = started.wait(seconds);
    return {code, files::read_whole_file(at("output"))};
  }
  std::string at(const std::string& name) const { return (folder_.path() / name).string(); }

  TemporaryFolder folder_;
};

}  // namespace marco::testing
