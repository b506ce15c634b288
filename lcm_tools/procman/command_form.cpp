#include "lcm_tools/procman/command_form.hpp"

#include <algorithm>
#include <charconv>

namespace marco::procman {
namespace {

[[noreturn]] void refuse(const char* field, const std::string& expected) {
  throw ConfigError({"the form", 0, 0}, std::string(field) + ": expected " + expected);
}

}  // namespace

CommandForm::CommandForm(const std::string& deputy, const std::string& group)
    : CommandForm(PlacedCommand{group, [&] {
                                  CommandConfig command;
                                  command.deputy = deputy;
                                  return command;
                                }()}) {
  edits_ = false;
  chosen_ = 0;
}

CommandForm::CommandForm(const PlacedCommand& placed)
    : label_(placed.command.label), chosen_(1), edits_(true) {
  const CommandConfig& command = placed.command;
  fields_ = {{"id", command.id},
             {"exec", command.exec},
             {"deputy", command.deputy},
             {"group", placed.group},
             {"auto_respawn", command.auto_respawn ? "true" : "false"},
             {"stop_signal", std::to_string(command.stop_signal)},
             {"stop_time_allowed", std::to_string(command.stop_time_allowed_s)},
             {"environment", command.environment},
             {"working_directory", command.working_directory}};
}

void CommandForm::move(int lines) {
  const int first = edits_ ? 1 : 0;
  const int last = static_cast<int>(fields_.size()) - 1;
  chosen_ = static_cast<std::size_t>(std::clamp(static_cast<int>(chosen_) + lines, first, last));
}

void CommandForm::type(char byte) { fields_[chosen_].text += byte; }

void CommandForm::erase() {
  std::string& text = fields_[chosen_].text;
  const auto follows = [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0) == 0x80; };
  while (!text.empty() && follows(text.back())) text.pop_back();
  if (!text.empty()) text.pop_back();
}

std::string CommandForm::text_of(const char* name) const {
  const auto field = std::find_if(fields_.begin(), fields_.end(),
                                  [&](const Field& one) { return std::string(one.name) == name; });
  return field == fields_.end() ? "" : field->text;
}

int CommandForm::number_of(const char* name, int min, int max) const {
  const std::string text = text_of(name);
  int value = 0;
  const auto end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end || value < min || value > max) {
    refuse(name, "a whole number from " + std::to_string(min) + " to " + std::to_string(max));
  }
  return value;
}

PlacedCommand CommandForm::command() const {
  constexpr int kMaxSeconds = 1'000'000;
  PlacedCommand placed;
  CommandConfig& command = placed.command;
  command.id = text_of("id");
  if (command.id.empty() || command.id.find('/') != std::string::npos) {
    refuse("id", "a name without '/'");
  }
  command.label = label_;
  command.exec = text_of("exec");
  if (command.exec.empty()) refuse("exec", "the command line");
  command.deputy = text_of("deputy");
  if (command.deputy.empty()) refuse("deputy", "the id of a deputy");
  placed.group = text_of("group");
  const std::string respawn = text_of("auto_respawn");
  if (respawn != "true" && respawn != "false") refuse("auto_respawn", "true or false");
  command.auto_respawn = respawn == "true";
  command.stop_signal = number_of("stop_signal", 1, kMaxSignal);
  command.stop_time_allowed_s = number_of("stop_time_allowed", 1, kMaxSeconds);
  command.environment = text_of("environment");
  command.working_directory = text_of("working_directory");
  return placed;
}

}  // namespace marco::procman
