#include "lcm_tools/process/command_line.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/suggest.hpp"
#include "lcm_tools/process/version.hpp"

namespace marco::process {
namespace {

std::size_t help_width() {
  winsize size = {};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0) return 100;
  return std::clamp<std::size_t>(size.ws_col, 80, 120);
}

// Where the text of a help line begins again after a break: at its description's column, if it has
// one.
std::size_t indent_of(const std::string& line) {
  const std::size_t first = line.find_first_not_of(' ');
  if (first == 0) return 0;
  const std::size_t gap = line.find("  ", first);
  return gap == std::string::npos ? first : line.find_first_not_of(' ', gap);
}

// Whether a line that was broken continues in the next one: prose does, up to its end in a list.
bool flows_on(const std::string& line, const std::string& next) {
  const auto is_prose = [](const std::string& one) {
    return one.find("  ", one.find_first_not_of(' ')) == std::string::npos;
  };
  if (next.empty() || next.starts_with("Usage:") || !is_prose(line) || !is_prose(next))
    return false;
  if (indent_of(line) != indent_of(next)) return false;
  return indent_of(line) == 0 || std::string_view(".:;)").find(line.back()) == std::string::npos;
}

// Lines that are longer than `width` are broken at spaces. A word that is too long stays whole.
std::string folded(const std::string& text, std::size_t width) {
  std::ostringstream result;
  std::istringstream lines(text);
  std::string rest, before;  // of the line before, if that was broken
  for (std::string line; std::getline(lines, line);) {
    const std::string whole = line;
    if (!rest.empty() && flows_on(before, line)) {
      line = rest + ' ' + line.substr(line.find_first_not_of(' '));
    } else if (!rest.empty()) {
      result << rest << '\n';
    }
    const bool is_broken = line.size() > width;
    const std::size_t indent = std::min(indent_of(line), width / 2);
    while (line.size() > width) {
      std::size_t space = line.rfind(' ', width);
      if (space == std::string::npos || space <= indent) space = line.find(' ', width);
      if (space == std::string::npos) break;
      result << line.substr(0, space) << '\n';
      line = std::string(indent, ' ') + line.substr(space + 1);
    }
    rest = is_broken ? line : "";
    if (!is_broken) result << line << '\n';
    before = whole;
  }
  if (!rest.empty()) result << rest << '\n';
  return result.str();
}

// The subcommand that was given, or the program itself.
const CLI::App& innermost(const CLI::App& app) {
  const auto given = app.get_subcommands();
  return given.empty() ? app : innermost(*given.back());
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

// CLI11's message, unless a word is unknown: then that is the mistake.
std::string mistake_of(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = innermost(app);
  for (const std::string& word : app.remaining(true)) {
    if (word.size() > 1 && word.front() == '-') {
      const std::string name = word.substr(0, word.find('='));
      return "unknown option '" + name + "'" + did_you_mean(name, option_names(command));
    }
    const std::vector<std::string> commands = command_names(command);
    if (commands.empty()) continue;
    return "unknown command '" + word + "'" + did_you_mean(word, commands);
  }
  return error.what();
}

}  // namespace

Option Option::required(bool is_required) {
  option_->required(is_required);
  return *this;
}

Option Option::shows_default() {
  option_->capture_default_str();
  return *this;
}

Option Option::described(const std::string& help) {
  option_->description(help);
  return *this;
}

Option Option::hidden() {
  option_->group("");
  return *this;
}

Option Option::value_name(const std::string& name) {
  option_->type_name(name);
  return *this;
}

Option Option::existing_file() {
  option_->check(CLI::ExistingFile);
  return *this;
}

Option Option::existing_folder() {
  option_->check(CLI::ExistingDirectory);
  return *this;
}

Option Option::existing_path() {
  option_->check(CLI::ExistingPath);
  return *this;
}

Option Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return *this;
}

Option Option::between(int least, int most) {
  option_->check(CLI::Range(least, most));
  return *this;
}

Option Option::between(double least, double most) {
  option_->check(CLI::Range(least, most));
  return *this;
}

Option Option::positive() {
  option_->check(CLI::PositiveNumber);
  return *this;
}

Option Option::not_negative() {
  option_->check(CLI::NonNegativeNumber);
  return *this;
}

Option Option::check(std::function<std::string(const std::string&)> fault_of) {
  option_->check(std::move(fault_of));
  return *this;
}

Option Option::values(int count) {
  option_->expected(count);
  return *this;
}

Option Option::values(int least, int most) {
  option_->expected(least, most);
  return *this;
}

Option Option::one_value_each_time() {
  option_->allow_extra_args(false);
  return *this;
}

Option Option::repeatable() {
  option_->take_all();
  return *this;
}

Option Option::needs(Option other) {
  option_->needs(other.option_);
  return *this;
}

Option Option::excludes(Option other) {
  option_->excludes(other.option_);
  return *this;
}

Option Option::excludes(const std::string& name) {
  option_->excludes(name);
  return *this;
}

CommandLine::CommandLine(const std::string& description, const std::string& name)
    : app_(std::make_shared<CLI::App>(description, name)) {}

CommandLine::CommandLine(std::shared_ptr<CLI::App> app) : app_(std::move(app)) {}

template <class T>
Option CommandLine::add_option(const std::string& names, T& value, const std::string& help) {
  return Option(app_->add_option(names, value, help));
}

template Option CommandLine::add_option(const std::string&, int&, const std::string&);
template Option CommandLine::add_option(const std::string&, int64_t&, const std::string&);
template Option CommandLine::add_option(const std::string&, uint64_t&, const std::string&);
template Option CommandLine::add_option(const std::string&, double&, const std::string&);
template Option CommandLine::add_option(const std::string&, std::string&, const std::string&);
template Option CommandLine::add_option(const std::string&, std::vector<int>&, const std::string&);
template Option CommandLine::add_option(const std::string&,
                                        std::vector<double>&,
                                        const std::string&);
template Option CommandLine::add_option(const std::string&,
                                        std::vector<std::string>&,
                                        const std::string&);

Option CommandLine::add_word(const std::string& names,
                             const std::string& help,
                             std::function<void(const std::string&)> given) {
  return Option(app_->add_option_function<std::string>(names, std::move(given), help));
}

Option CommandLine::add_flag(const std::string& names, bool& value, const std::string& help) {
  return Option(app_->add_flag(names, value, help));
}

Option CommandLine::add_flag(const std::string& names,
                             std::function<void()> given,
                             const std::string& help) {
  return Option(app_->add_flag_callback(names, std::move(given), help));
}

Option CommandLine::add_flag_that_ends(const std::string& names,
                                       std::function<void()> given,
                                       const std::string& help) {
  return add_flag(
      names,
      [given = std::move(given)] {
        given();
        throw CLI::Success();
      },
      help);
}

Option CommandLine::option(const std::string& name) const { return Option(app_->get_option(name)); }

CommandLine CommandLine::add_subcommand(const std::string& name,
                                        const std::string& help,
                                        std::function<void()> given) {
  CLI::App* command = app_->add_subcommand(name, help);
  if (given) command->callback(std::move(given));
  return CommandLine(std::shared_ptr<CLI::App>(app_, command));
}

void CommandLine::require_subcommand() { app_->require_subcommand(1); }

std::optional<int> CommandLine::parse(int argc, const char* const* argv) {
  if (app_->get_name().empty()) app_->name(std::filesystem::path(argv[0]).filename());
  const std::string name = app_->get_name();
  app_->set_version_flag("--version", name + " " + version(), "print the version and exit");
  try {
    app_->parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    std::fputs(folded(app_->help(), help_width()).c_str(), stdout);
    return kExitDone;
  } catch (const CLI::Success& stop) {
    return app_->exit(stop);
  } catch (const CLI::ParseError& mistake) {
    std::fprintf(stderr, "%s: %s\nTry %s --help\n", name.c_str(),
                 mistake_of(*app_, mistake).c_str(), name.c_str());
    return kExitUsage;
  }
  return std::nullopt;
}

}  // namespace marco::process
