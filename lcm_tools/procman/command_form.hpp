#pragma once

#include <string>
#include <vector>

#include "lcm_tools/procman/config.hpp"

namespace marco::procman {

/// A command as a form of text fields. Independent of screen and keyboard.
class CommandForm {
 public:
  struct Field {
    const char* name;  ///< as in the file
    std::string text;
  };

  /// A new command. @param deputy, group  proposed.
  CommandForm(const std::string& deputy, const std::string& group);
  /// An existing command; its id cannot be changed.
  explicit CommandForm(const PlacedCommand& placed);

  const std::vector<Field>& fields() const { return fields_; }
  std::size_t chosen() const { return chosen_; }
  bool edits() const { return edits_; }

  void move(int lines);
  void type(char byte);
  void erase();  ///< the last character, of however many bytes

  /// @throws ConfigError naming the field and what was expected.
  PlacedCommand command() const;

 private:
  std::string text_of(const char* name) const;
  int number_of(const char* name, int min, int max) const;

  std::vector<Field> fields_;
  std::string label_;
  std::size_t chosen_ = 0;
  bool edits_ = false;
};

}  // namespace marco::procman
