#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lcm_tools/log/output_file.hpp"

/// The subcommands of marco-log as functions. Each shows its progress on stderr and prints its
/// result on stdout. All throw std::invalid_argument or std::runtime_error with a message for the
/// user, and NoLogError where an input holds no event.
namespace marco::logs {

struct ExportFormat;
struct Extensions;

enum class Format { text, json };

struct InfoArguments {
  std::vector<std::string> logs;
  std::vector<std::string> types;  ///< additional .lcm sources
  Format format = Format::text;
  /// What is in a file of another kind; nothing for LCM logs. May be empty.
  std::function<std::optional<std::string>(const std::string& path, Format format)> describe = {};
};
void run_info(const InfoArguments& arguments);

struct SelectArguments {
  std::string in, out;
  std::string from, to;  ///< as parse_moment; "" = open
  std::vector<std::string> channels;
  bool drop = false;  ///< drop the channels instead of keeping them
  Existing existing = Existing::refuse;
};
/// cut and filter.
void run_select(const SelectArguments& arguments);

struct MergeArguments {
  std::vector<std::string> ins;
  std::string out;
  std::vector<double> shifts_s;
  std::vector<std::string> prefixes;
  Existing existing = Existing::refuse;
};
void run_merge(const MergeArguments& arguments);

struct RepairArguments {
  std::string in, out;
  std::vector<std::string> types;
  bool as_is = false;  ///< repair nothing
  Format format = Format::text;
  Existing existing = Existing::refuse;
};
void run_repair(const RepairArguments& arguments);

struct RecordingsArguments {
  std::string home;  ///< "" = recorder::default_home()
};
/// What marco-recorder recorded: name, length, size, and what is never deleted.
void run_recordings(const RecordingsArguments& arguments);

struct KeepArguments {
  std::vector<std::string> recordings;  ///< folders, or names in recorder::default_home()
  bool undo = false;
};
void run_keep(const KeepArguments& arguments);

struct ExportArguments {
  std::string in, out;
  std::string format;  ///< name of an ExportFormat; "" = by the ending of OUT
  std::vector<std::string> types;
  std::string from, to;
  std::vector<std::string> channels;
  Existing existing = Existing::refuse;
};
/// csv, jsonl, mcap and images, then the formats of the extensions.
std::vector<ExportFormat> export_formats(const Extensions& extensions);
void run_export(const ExportArguments& arguments, std::span<const ExportFormat> formats);

struct PlayArguments {
  std::string in;
  std::string lcm_url;
  std::string from, to;
  double speed = 1.0;
  double longest_wait_s = 0.0;  ///< 0 = gaps keep their length
  bool loop = false;
  bool paused = false;
  bool keys = true;
  std::vector<std::string> channels;
  bool drop = false;
  std::vector<std::string> renames;
  bool orders = false;                           ///< publish orders, too
  std::vector<std::string_view> order_channels;  ///< what counts as an order
};
void run_play(const PlayArguments& arguments);

}  // namespace marco::logs
