#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace marco::process {

/// An option, a flag or a positional argument of a CommandLine. A handle: copies mean the same
/// option, and it is valid as long as its command line. Each call returns the option itself.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option required(bool is_required = true);
  /// Help shows the value that the variable has now.
  Option shows_default();
  Option described(const std::string& help);
  /// Help leaves it out.
  Option hidden();
  /// The name of its value in the help, e.g. "X Y DEG".
  Option value_name(const std::string& name);

  Option existing_file();
  Option existing_folder();
  Option existing_path();
  Option one_of(const std::vector<std::string>& words);
  Option between(int least, int most);
  Option between(double least, double most);
  Option positive();
  Option not_negative();
  /// @param fault_of  of a word as typed: what is wrong with it, or ""
  Option check(std::function<std::string(const std::string&)> fault_of);

  /// Just this number of values.
  Option values(int count);
  Option values(int least, int most);
  /// Takes one value each time that it is given.
  Option one_value_each_time();
  /// May be given several times; all values count.
  Option repeatable();

  Option needs(Option other);
  Option excludes(Option other);
  /// @throws std::exception where no option of that name was added before
  Option excludes(const std::string& name);

 private:
  CLI::Option* option_;
};

/// The command line of a program, or of one of its subcommands: options write to variables of the
/// caller, which outlive the parsing. A handle: copies mean the same command line. Not safe from
/// several threads.
///
/// CLI11 does the work. Its header takes a compiler eight seconds, so command_line.cpp alone
/// includes it.
class CommandLine {
 public:
  /// @param name  of the program; "" = the file that was started
  explicit CommandLine(const std::string& description, const std::string& name = "");

  /// @param names  "-o,--out" of an option, "OUT" of a positional argument
  /// @tparam T  int, int64_t, uint64_t, double, std::string, or std::vector<> of int, double or
  ///   std::string
  template <class T>
  Option add_option(const std::string& names, T& value, const std::string& help = "");

  /// An option whose value is one of `words`; another is refused.
  template <class T>
  Option add_choice(const std::string& names,
                    T& value,
                    const std::map<std::string, T>& words,
                    const std::string& help) {
    std::vector<std::string> allowed;
    allowed.reserve(words.size());
    for (const auto& [word, meaning] : words) allowed.push_back(word);
    return add_word(names, help,
                    [&value, words](const std::string& word) { value = words.at(word); })
        .one_of(allowed);
  }

  Option add_flag(const std::string& names, bool& value, const std::string& help = "");
  /// @param given  is called while parsing
  Option add_flag(const std::string& names, std::function<void()> given, const std::string& help);
  /// As --help: the flag is obeyed before anything is found missing, and the program is done.
  Option add_flag_that_ends(const std::string& names,
                            std::function<void()> given,
                            const std::string& help);

  /// @throws std::exception where it was not added before
  Option option(const std::string& name) const;

  /// @param given  is called after parsing, if the subcommand was given
  CommandLine add_subcommand(const std::string& name,
                             const std::string& help,
                             std::function<void()> given = {});
  /// One subcommand must be given.
  void require_subcommand();

  /// Parses. Prints help, folded to the terminal's width (80 to 120 columns; elsewhere 100), the
  /// version (--version) or the mistake, with a suggestion for an unknown word. @returns an exit
  /// code when the program should end now: kExitDone, kExitUsage. What a subcommand's callback
  /// throws passes through.
  std::optional<int> parse(int argc, const char* const* argv);

 private:
  explicit CommandLine(std::shared_ptr<CLI::App> app);

  Option add_word(const std::string& names,
                  const std::string& help,
                  std::function<void(const std::string&)> given);

  std::shared_ptr<CLI::App> app_;
};

}  // namespace marco::process
