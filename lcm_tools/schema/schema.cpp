#include "lcm_tools/schema/schema.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "lcm_tools/base/format.hpp"
#include "lcm_tools/schema/parser.hpp"

namespace marco::lcm_schema {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFiles = 20000;
constexpr std::uintmax_t kMaxFileBytes = 4U << 20U;
constexpr int kMaxHashSteps = 5000;  // the recursion below is exponential for a hostile source

// lcm-gen's hash: shift, fold the top bits in (an arithmetic shift), add the character.
void update(int64_t& hash, char c) {
  hash = static_cast<int64_t>(
      ((static_cast<uint64_t>(hash) << 8U) ^ static_cast<uint64_t>(hash >> 55)) +
      static_cast<uint64_t>(static_cast<int64_t>(static_cast<signed char>(c))));
}

void update(int64_t& hash, std::string_view text) {
  update(hash, static_cast<char>(text.size()));
  for (const char c : text) update(hash, c);
}

std::string short_name(const std::string& name) { return name.substr(name.rfind('.') + 1); }

// Of the fields' names, primitive types and dimensions; the types of compound fields come in later.
uint64_t base_hash(const Structure& structure) {
  if (structure.is_enum) {
    int64_t hash = 0x87654321;
    update(hash, short_name(structure.name));
    return static_cast<uint64_t>(hash);
  }
  int64_t hash = 0x12345678;
  for (const Member& member : structure.members) {
    update(hash, member.name);
    if (member.primitive) update(hash, member.type);
    update(hash, static_cast<char>(member.dimensions.size()));
    for (const Dimension& dimension : member.dimensions) {
      update(hash, static_cast<char>(dimension.member >= 0 ? 1 : 0));
      update(hash, dimension.size);
    }
  }
  return static_cast<uint64_t>(hash);
}

std::string folder_of(const std::string& source) {
  const std::size_t slash = source.rfind('/');
  return slash == std::string::npos ? std::string() : source.substr(0, slash);
}

void read_file(const fs::path& path, std::vector<Source>& sources, std::vector<Problem>& problems) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  std::ifstream file;
  if (!error) file.open(path, std::ios::binary);  // no pipe, for a size is known
  if (error || !file || size > kMaxFileBytes) {
    problems.push_back(
        {path.string() + (size > kMaxFileBytes && !error
                              ? ": larger than 4 MB"
                              : ": cannot be read: " + std::string(std::strerror(errno)))});
    return;
  }
  sources.push_back({path.string(), {std::istreambuf_iterator<char>(file), {}}});
}

}  // namespace

std::size_t wire_bytes(Primitive primitive) {
  switch (primitive) {
    case Primitive::int8:
    case Primitive::boolean:
    case Primitive::byte:
      return 1;
    case Primitive::int16:
      return 2;
    case Primitive::int32:
    case Primitive::float32:
      return 4;
    case Primitive::int64:
    case Primitive::float64:
      return 8;
    case Primitive::string:
      return 0;
  }
  return 0;
}

const char* name_of(Primitive primitive) {
  static constexpr const char* kNames[] = {"int8_t", "int16_t", "int32_t", "int64_t", "float",
                                           "double", "string",  "boolean", "byte"};
  return kNames[static_cast<int>(primitive)];
}

std::vector<Source> read_sources(const std::string& path, std::vector<Problem>& problems) {
  std::vector<Source> sources;
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    read_file(path, sources, problems);
    return sources;
  }
  std::vector<fs::path> files;
  fs::recursive_directory_iterator entry(path, fs::directory_options::skip_permission_denied,
                                         error);
  for (; !error && entry != fs::recursive_directory_iterator() && files.size() < kMaxFiles;
       entry.increment(error)) {
    std::error_code ignored;
    if (entry->path().extension() == ".lcm" && entry->is_regular_file(ignored)) {
      files.push_back(entry->path());
    }
  }
  if (error) problems.push_back({path + ": " + error.message()});
  if (files.size() == kMaxFiles)
    problems.push_back({path + ": only the first 20000 files are read"});
  if (files.empty() && !error) problems.push_back({path + ": no .lcm file in it"});
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) read_file(file, sources, problems);
  return sources;
}

Schema::Schema(const std::vector<Source>& sources) {
  for (const Source& source : sources) {
    for (Structure& structure : parse_source(source, problems_)) {
      by_name_[structure.name].push_back(static_cast<int>(structures_.size()));
      base_hashes_.push_back(base_hash(structure));
      structures_.push_back(std::move(structure));
    }
  }
  link();
}

int Schema::resolve(const Structure& user, const std::string& full_name) const {
  const auto found = by_name_.find(full_name);
  if (found == by_name_.end()) return -1;
  int best = -1;
  int best_rank = -1;
  for (const int index : found->second) {
    const std::string& source = structures_[static_cast<std::size_t>(index)].source;
    const int rank =
        source == user.source ? 2 : (folder_of(source) == folder_of(user.source) ? 1 : 0);
    if (rank >= best_rank) {
      best = index;
      best_rank = rank;
    }
  }
  return best;
}

void Schema::link() {
  for (Structure& structure : structures_) {
    for (Member& member : structure.members) {
      if (member.primitive) continue;
      member.structure = resolve(structure, member.type);
      if (member.structure >= 0) continue;
      structure.complete = false;
      problems_.push_back({structure.source + ":" + std::to_string(structure.line) + ": " +
                           structure.name + "." + member.name + " needs the type " + member.type +
                           ", which no source declares"});
    }
  }
  find_incomplete();
  for (int i = static_cast<int>(structures_.size()) - 1; i >= 0; --i) {
    Structure& structure = structures_[static_cast<std::size_t>(i)];
    if (!structure.complete) continue;
    HashWalk walk;
    structure.fingerprint = fingerprint(i, walk);
    structure.complete = walk.steps <= kMaxHashSteps;
    if (structure.is_enum) continue;
    if (!structure.complete) {
      problems_.push_back({structure.source + ":" + std::to_string(structure.line) + ": " +
                           structure.name + " nests too many types"});
      continue;
    }
    std::vector<int>& same = by_fingerprint_[structure.fingerprint];
    const bool repeated = std::any_of(same.begin(), same.end(), [&](int other) {
      return structures_[static_cast<std::size_t>(other)].name == structure.name;
    });
    if (!repeated) same.push_back(i);
  }
  // Enums are numbers from here on.
  for (Structure& structure : structures_) {
    for (Member& member : structure.members) {
      if (member.structure >= 0 &&
          structures_[static_cast<std::size_t>(member.structure)].is_enum) {
        member.primitive = Primitive::int32;
      }
    }
  }
}

// A type that needs an incomplete one is incomplete: spread until nothing changes.
void Schema::find_incomplete() {
  for (bool changed = true; changed;) {
    changed = false;
    for (Structure& structure : structures_) {
      if (!structure.complete) continue;
      structure.complete = std::all_of(
          structure.members.begin(), structure.members.end(), [&](const Member& member) {
            return member.primitive ||
                   structures_[static_cast<std::size_t>(member.structure)].complete;
          });
      changed = changed || !structure.complete;
    }
  }
}

// The recursion of the generated code: base hash plus those of the compound members, rotated by
// one; a type inside itself counts nothing.
uint64_t Schema::fingerprint(int structure, HashWalk& walk) const {
  const Structure& self = structures_[static_cast<std::size_t>(structure)];
  uint64_t hash = base_hashes_[static_cast<std::size_t>(structure)];
  if (self.is_enum) return hash;
  if (++walk.steps > kMaxHashSteps) return 0;
  if (std::find(walk.parents.begin(), walk.parents.end(), structure) != walk.parents.end())
    return 0;
  walk.parents.push_back(structure);
  for (const Member& member : self.members) {
    if (member.structure >= 0) hash += fingerprint(member.structure, walk);
  }
  walk.parents.pop_back();
  return (hash << 1U) + (hash >> 63U);
}

std::span<const int> Schema::with_fingerprint(uint64_t fingerprint) const {
  const auto found = by_fingerprint_.find(fingerprint);
  if (found == by_fingerprint_.end()) return {};
  return found->second;
}

std::optional<int> Schema::find(std::string_view name) const {
  const auto found = by_name_.find(std::string(name));
  if (found != by_name_.end()) return found->second.back();
  std::optional<int> result;
  for (const auto& [full_name, indices] : by_name_) {
    if (short_name(full_name) != name) continue;
    if (result) return {};
    result = indices.back();
  }
  return result;
}

std::optional<uint64_t> fingerprint_of(std::span<const uint8_t> message) {
  if (message.size() < 8) return {};
  uint64_t big_endian = 0;
  std::memcpy(&big_endian, message.data(), sizeof big_endian);
  return __builtin_bswap64(big_endian);
}

Schema load_schema(std::vector<Source> sources,
                   const std::vector<std::string>& paths,
                   std::vector<std::string>& problems) {
  std::vector<Problem> found;
  for (const std::string& path : paths) {
    for (Source& source : read_sources(path, found)) sources.push_back(std::move(source));
  }
  Schema schema(sources);
  found.insert(found.end(), schema.problems().begin(), schema.problems().end());
  for (Problem& problem : found) problems.push_back(std::move(problem.message));
  return schema;
}

std::string fingerprint_text(uint64_t fingerprint) {
  return format("%016llx", static_cast<unsigned long long>(fingerprint));
}

}  // namespace marco::lcm_schema
