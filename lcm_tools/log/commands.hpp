#pragma once

#include <string>
#include <vector>

#include "lcm_tools/log/output_file.hpp"

/// The subcommands of marco-log as functions: each does its work with a progress line on stderr,
/// prints what it did on stdout and returns the exit code. All throw std::invalid_argument or
/// std::runtime_error with a message for a person.
namespace marco::logs {

enum class Format { text, json };

struct InfoArguments {
  std::vector<std::string> logs;
  std::vector<std::string> types;  ///< further .lcm sources
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

struct RepairArguments {
  std::string in, out;
  std::vector<std::string> types;
  bool as_is = false;  ///< mend nothing
  Format format = Format::text;
  Existing existing = Existing::refuse;
};
int run_repair(const RepairArguments& arguments);

struct ImportArguments {
  std::string in, out;
  Existing existing = Existing::refuse;
};
int run_import(const ImportArguments& arguments);

struct ExportArguments {
  std::string in, out;
  std::string format;  ///< csv, jsonl, carmen, mcap or images; "" = by OUT's ending
  std::vector<std::string> types;
  std::string from, to;
  std::vector<std::string> channels;
  std::string foreign;  ///< carmen: what foreign channels mean
  Existing existing = Existing::refuse;
};
int run_export(const ExportArguments& arguments);

struct PlayArguments {
  std::string in;
  std::string lcm_url;
  std::string from, to;
  double speed = 1.0;
  double longest_wait_s = 0.0;  ///< 0 = as long as it was
  bool loop = false;
  bool paused = false;
  bool keys = true;
  std::vector<std::string> channels;
  bool drop = false;
  std::vector<std::string> renames;
  bool orders = false;  ///< publish what was ordered then (channels::kOrders), too
};
int run_play(const PlayArguments& arguments);

}  // namespace marco::logs
