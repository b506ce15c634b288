#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

/// LCM message types read at run time from `.lcm` sources: the types of a message are known to
/// Marco's tools without a compiler. Three steps: sources (schema.hpp) -> Schema -> Decoder
/// (decoder.hpp) -> Tree or JSON text (json.hpp).
namespace marco::lcm_schema {

/// The built-in types of the language; an enum field is an int32.
enum class Primitive : uint8_t {
  int8,
  int16,
  int32,
  int64,
  float32,
  float64,
  string,
  boolean,
  byte
};

/// [byte] of one value on the wire; 0 for a string (its length varies).
std::size_t wire_bytes(Primitive primitive);
/// "int8_t", "float", ... as written in a source.
const char* name_of(Primitive primitive);

/// One pair of brackets.
struct Dimension {
  std::string size;      ///< as written: "3", "0x10", a constant's value, the name of a member
  int64_t constant = 0;  ///< > 0: that many elements; 0: `member` says how many
  int member = -1;       ///< index of an integer member before this one
};

struct Member {
  std::string name;
  std::string type;                    ///< as written
  std::optional<Primitive> primitive;  ///< nothing: `structure` is its type
  int structure = -1;                  ///< index into Schema::structures()
  std::vector<Dimension> dimensions;
};

struct Constant {
  std::string name;
  std::string type;
  std::string value;  ///< as written
};

struct Structure {
  std::string name;  ///< with package: "bot_core.pose_t"
  std::vector<Member> members;
  std::vector<Constant> constants;
  std::string source;        ///< file name (or what add_text was told) and
  int line = 0;              ///< line of the declaration
  bool is_enum = false;      ///< `constants` are its values; never a message of its own
  bool complete = true;      ///< every type it needs is known; otherwise it decodes nothing
  uint64_t fingerprint = 0;  ///< what lcm-gen's getHash() returns
};

/// A text to parse. `name` appears in problems and decides which folder the source is in (see
/// Schema).
struct Source {
  std::string name;
  std::string text;
};

/// A mistake in a source, as a message for the user: "mine/foo_t.lcm:7:12: expected ';' after the
/// field".
struct Problem {
  std::string message;
};

/// Every `.lcm` file at `path`: a file, or a folder searched with its sub-folders (names sorted, at
/// most 20 000 files of 4 MB). What cannot be read is a problem, not an exception.
std::vector<Source> read_sources(const std::string& path, std::vector<Problem>& problems);

/// All types of a set of sources, linked. A wrong declaration is reported and left out, the rest of
/// the set still works. Two sources may declare one name differently (forks of a package): both
/// stay; a field's type is then looked for in the same source, then in the same folder, then in the
/// latest source. Immutable, safe from several threads.
class Schema {
 public:
  Schema() : Schema(std::vector<Source>{}) {}
  explicit Schema(const std::vector<Source>& sources);

  const std::vector<Structure>& structures() const { return structures_; }
  const std::vector<Problem>& problems() const { return problems_; }

  /// Indices of all complete types with this fingerprint, later sources first. Several are
  /// possible: names of packages and types are not part of it.
  std::span<const int> with_fingerprint(uint64_t fingerprint) const;

  /// Index of the type with this name ("pkg.type_t", or "type_t" when only one package has it);
  /// the latest when there are several, nothing when there is none.
  std::optional<int> find(std::string_view name) const;

 private:
  void link();
  int resolve(const Structure& user, const std::string& full_name) const;
  void find_incomplete();
  struct HashWalk {
    std::vector<int> parents;
    int steps = 0;
  };
  uint64_t fingerprint(int structure, HashWalk& walk) const;

  std::vector<Structure> structures_;
  std::vector<uint64_t> base_hashes_;
  std::vector<Problem> problems_;
  std::unordered_map<std::string, std::vector<int>> by_name_;
  std::unordered_map<uint64_t, std::vector<int>> by_fingerprint_;
};

/// The types of `sources` and of the files and folders in `paths`, which come later.
/// @param problems  gets a line for the user for each mistake
Schema load_schema(std::vector<Source> sources,
                   const std::vector<std::string>& paths,
                   std::vector<std::string>& problems);

/// The first 8 bytes of a message; nothing when it is shorter.
std::optional<uint64_t> fingerprint_of(std::span<const uint8_t> message);

/// Whether a message is of the type that lcm-gen made, or of another stack's with the same fields.
template <class Message>
bool is_a(std::optional<uint64_t> fingerprint) {
  return fingerprint == static_cast<uint64_t>(Message::getHash());
}
template <class Message>
bool is_a(std::span<const uint8_t> message) {
  return is_a<Message>(fingerprint_of(message));
}

/// 16 hexadecimal digits.
std::string fingerprint_text(uint64_t fingerprint);

}  // namespace marco::lcm_schema
