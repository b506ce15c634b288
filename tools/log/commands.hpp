#pragma once

#include <string>
#include <vector>

#include "tools/log/output_file.hpp"

/// The subcommands of marco-log as functions: each does its work with a progress line on stderr,
/// prints what it did on stdout and returns the exit code. All throw std::invalid_argument or
/// std::runtime_error with a message for a person.
namespace marco::logs {

enum class Format { text, json };

struct InfoArguments {
  std::vector<std::string> logs;
  Format format = Format::text;
};
int run_info(const InfoArguments& arguments);

struct SelectArguments {
  std::string in, out;
  std::string from, to;  ///< as parse_moment; "" = open
  std::vector<std::string> channels;
  bool drop = false;  ///< the channels instead of keeping them
  Existing existing = Existing::refuse;
};
/// cut and filter.
int run_select(const SelectArguments& arguments);

struct MergeArguments {
  std::vector<std::string> ins;
  std::string out;
  std::vector<double> shifts_s;
  std::vector<std::string> prefixes;
  Existing existing = Existing::refuse;
};
int run_merge(const MergeArguments& arguments);

}  // namespace marco::logs
