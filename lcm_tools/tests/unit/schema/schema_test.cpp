#include "lcm_tools/schema/schema.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "bot_core/image_metadata_t.hpp"
#include "bot_core/image_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "lcm_tools/schema/built_in_sources.hpp"
#include "marco/emergency_stop_t.hpp"
#include "marco/process_status_t.hpp"
#include "schema_test/inner/all_t.hpp"
#include "schema_test/inner/empty_t.hpp"
#include "schema_test/inner/tree_t.hpp"

namespace marco::lcm_schema {
namespace {

using Sources = std::vector<Source>;

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

template <class Message>
std::pair<std::string, uint64_t> generated(const std::string& package = "marco.") {
  return {package + Message::getTypeName(), static_cast<uint64_t>(Message::getHash())};
}

uint64_t fingerprint(const Schema& schema, const std::string& name) {
  const auto index = schema.find(name);
  return index ? schema.structures()[static_cast<std::size_t>(*index)].fingerprint : 0;
}

std::vector<std::string> messages(const Schema& schema) {
  std::vector<std::string> result;
  for (const Problem& problem : schema.problems()) result.push_back(problem.message);
  return result;
}

TEST(Schema, FingerprintsOfBuiltInTypesAreLcmGensOwn) {
  const Schema schema(built_in_sources());
  EXPECT_THAT(messages(schema), IsEmpty());
  const std::map<std::string, uint64_t> expected = {
      generated<bot_core::image_t>("bot_core."),
      generated<bot_core::image_metadata_t>("bot_core."),
      generated<bot_core::planar_lidar_t>("bot_core."),
      generated<bot_core::pose_t>("bot_core."),
      generated<emergency_stop_t>(),
      generated<process_status_t>()};
  for (const auto& [name, hash] : expected) EXPECT_EQ(fingerprint(schema, name), hash) << name;
}

TEST(Schema, FingerprintsOfEveryConstructAreLcmGensOwn) {
  std::vector<Problem> problems;
  const Schema schema(read_sources("tests/unit/schema/test_types.lcm", problems));
  EXPECT_THAT(problems, IsEmpty());
  EXPECT_THAT(messages(schema), IsEmpty());
  using schema_test::inner::all_t;
  EXPECT_EQ(fingerprint(schema, "all_t"), static_cast<uint64_t>(all_t::getHash()));
  EXPECT_EQ(fingerprint(schema, "schema_test.inner.empty_t"),
            static_cast<uint64_t>(schema_test::inner::empty_t::getHash()));
  EXPECT_EQ(fingerprint(schema, "tree_t"),
            static_cast<uint64_t>(schema_test::inner::tree_t::getHash()));
}

// The base hash lcm-gen writes into the header of a type.
uint64_t generated_hash(const std::string& folder, const std::string& type) {
  std::ifstream header(folder + "/" + type + ".hpp");
  const std::string text{std::istreambuf_iterator<char>(header), {}};
  const std::size_t at = text.find("hash = 0x");
  return at == std::string::npos ? 0 : std::stoull(text.substr(at + 7), nullptr, 16);
}

// Each type beside the one lcm-gen 1.3.1 is given: it knows no arrays sized by constants, which
// later versions treat as ones sized by the constants' values.
TEST(Schema, EveryKindOfDimensionHashesAsLcmGensDoes) {
  struct Case {
    const char* ours;
    const char* theirs;  // "" = the same
  };
  const Case cases[] = {
      {"int8_t arr[10];", ""},
      {"int8_t arr[0x0a];", ""},
      {"int8_t arr[012];", ""},
      {"int8_t n; int8_t arr[n];", ""},
      {"int64_t n; double arr[n];", ""},
      {"int16_t n; int32_t m; float arr[n][3][m][0x2];", ""},
      {"string s[4]; boolean b[1][2];", ""},
      {"const int8_t dim = 10; int8_t arr[dim];", "int8_t arr[10];"},
      {"const int64_t dim = 10; int8_t arr[dim];", "int8_t arr[10];"},
      {"const int32_t dim = 0x0a; int8_t arr[dim];", "int8_t arr[0x0a];"},
      {"const int16_t one = -7, dim = 010, last = 2; int8_t arr[dim];", "int8_t arr[010];"},
      {"const int16_t w = 4, h = 0x2; int32_t n; double a[w][n]; double b[h][w][3];",
       "int32_t n; double a[4][n]; double b[0x2][4][3];"},
      {"const double HALF = 0.5; const int32_t dim = 3; int32_t n; int8_t a[n], b[dim];",
       "int32_t n; int8_t a[n], b[3];"},
  };
  const std::string folder =
      (std::filesystem::temp_directory_path() / ("lcm_gen_" + std::to_string(getpid()))).string();
  std::filesystem::create_directories(folder);
  std::string ours, theirs;
  for (std::size_t i = 0; i < std::size(cases); ++i) {
    const std::string head = "struct type" + std::to_string(i) + "_t { ";
    ours += head + cases[i].ours + " }\n";
    theirs += head + (*cases[i].theirs == '\0' ? cases[i].ours : cases[i].theirs) + " }\n";
  }
  std::ofstream(folder + "/types.lcm") << theirs;
  const std::string command = "lcm-gen --cpp --cpp-hpath " + folder + " " + folder + "/types.lcm";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const Schema schema(Sources{{"ours.lcm", ours}});
  EXPECT_THAT(messages(schema), IsEmpty());
  for (std::size_t i = 0; i < std::size(cases); ++i) {
    const std::string type = "type" + std::to_string(i) + "_t";
    const uint64_t base = generated_hash(folder, type);
    ASSERT_NE(base, 0U) << type;
    EXPECT_EQ(fingerprint(schema, type), (base << 1U) + (base >> 63U)) << cases[i].ours;
  }
  std::filesystem::remove_all(folder);
}

TEST(Schema, AConstantOfNoUsableSizeSizesNoArray) {
  for (const char* wrong :
       {"const int32_t n = -3; int8_t a[n];", "const int32_t n = 0; int8_t a[n];",
        "const double n = 3; int8_t a[n];", "const int64_t n = 5000000000; int8_t a[n];",
        "int8_t a[n]; const int32_t n = 3;"}) {
    const Schema schema(Sources{{"x.lcm", std::string("struct x_t { ") + wrong + " }"}});
    EXPECT_THAT(messages(schema), SizeIs(1)) << wrong;
    EXPECT_FALSE(schema.find("x_t")) << wrong;
  }
}

// Public types, of which only facts are kept: sources are written of them.
TEST(Schema, PublicTypesHaveTheirPublishedFingerprints) {
  const char* data = std::getenv("MARCO_TEST_DATA");
  const std::string folder = std::string(data == nullptr ? "" : data) + "/lcm_types_public/";
  std::ifstream types(folder + "types.csv"), fingerprints(folder + "fingerprints.csv");
  if (data == nullptr || !types) {
    std::puts("SKIPPED: no lcm_types_public in MARCO_TEST_DATA");
    return;
  }
  const auto columns = [](const std::string& line) {
    std::vector<std::string> result(1);
    for (const char c : line) {
      if (c == ',') {
        result.emplace_back();
      } else if (c != '\r') {
        result.back() += c;
      }
    }
    result.resize(7);
    return result;
  };
  std::map<std::string, std::map<std::string, std::string>> sets;  // set -> type -> members
  std::string line;
  std::getline(types, line);
  std::vector<std::array<std::string, 3>> published;  // set, type, fingerprint
  std::getline(fingerprints, line);
  while (std::getline(fingerprints, line)) {
    const auto column = columns(line);
    published.push_back({column[0], column[1], column[2]});
    sets[column[0]][column[1]];  // a type without members has no line of its own
  }
  std::set<std::string> seen;
  while (std::getline(types, line)) {
    if (!seen.insert(line).second) continue;  // a type that two sources declare alike
    const auto column = columns(line);        // set, type, kind, order, lcm_type, name, dimensions
    std::string& members = sets[column[0]][column[1]];
    if (column[2] == "const") members += "const ";
    members += column[4] + " " + column[5];
    std::istringstream sizes(column[6]);
    for (std::string size; sizes >> size;) members += "[" + size + "]";
    members += ";\n";
  }
  std::map<std::string, Schema> schemas;
  for (const auto& [set, members] : sets) {
    Sources sources;
    for (const auto& [type, text] : members) {
      const std::size_t dot = type.rfind('.');
      const bool has_package = dot != std::string::npos;
      const std::string package = has_package ? "package " + type.substr(0, dot) + ";\n" : "";
      const std::string name = has_package ? type.substr(dot + 1) : type;
      sources.push_back({set + "/" + type, package + "struct " + name + " {\n" + text + "}"});
    }
    schemas.emplace(set, Schema(sources));
    EXPECT_THAT(messages(schemas.at(set)), IsEmpty());
  }
  int same = 0;
  for (const auto& [set, type, hash] : published) {
    const uint64_t expected = std::stoull(hash, nullptr, 16);
    EXPECT_EQ(fingerprint(schemas.at(set), type), expected) << type;
    same += fingerprint(schemas.at(set), type) == expected ? 1 : 0;
  }
  std::printf("%d public types\n", same);
  EXPECT_GE(same, 300);
}

// What lcm-gen 1.3.1 prints for mbot's own sources.
TEST(Schema, ForeignTypesHaveTheirPublishedFingerprints) {
  const Schema schema(Sources{{"foreign.lcm", R"(
      package mbot_lcm_msgs;
      struct pose2D_t { int64_t utime; float x, y, theta; }
      struct path2D_t { int64_t utime; int32_t path_length; pose2D_t path[path_length]; }
      struct particle_t { pose2D_t pose; pose2D_t parent_pose; double weight; }
      struct particles_t { int64_t utime; int32_t num_particles; particle_t particles[num_particles]; }
      struct timestamp_t { int64_t utime; })"}});
  EXPECT_THAT(messages(schema), IsEmpty());
  EXPECT_EQ(fingerprint(schema, "pose2D_t"), 0x1f317af1246276acU);
  EXPECT_EQ(fingerprint(schema, "path2D_t"), 0xefadf583af374079U);
  EXPECT_EQ(fingerprint(schema, "particles_t"), 0xe2a767ec6d2ab420U);
  EXPECT_EQ(fingerprint(schema, "timestamp_t"), 0x4d0d41c1f105b12fU);
}

// The value lcm-gen --c wrote for: enum col_t { RED=1, BLUE=2 }  struct e_t { col_t c; }
TEST(Schema, AnEnumIsANumberWithNames) {
  const Schema schema(Sources{{"e.lcm", "enum col_t { RED=1, BLUE } struct e_t { col_t c; }"}});
  EXPECT_THAT(messages(schema), IsEmpty());
  const Structure& type = schema.structures()[1];
  const uint64_t sum = 0x0012345678016300U + 0x432105636f6d92a9U;
  EXPECT_EQ(type.fingerprint, (sum << 1U) + (sum >> 63U));
  EXPECT_EQ(type.members[0].primitive, Primitive::int32);
  EXPECT_EQ(schema.structures()[0].constants[1].value, "2");
}

TEST(Schema, AMistakeIsSaidWithItsPlaceAndTheRestStillWorks) {
  const auto first_problem = [](const std::string& text) {
    const Schema schema(Sources{{"x.lcm", text + "\nstruct good_t { int8_t a; }"}});
    EXPECT_TRUE(schema.find("good_t")) << text;
    return schema.problems().empty() ? std::string("none") : schema.problems()[0].message;
  };
  EXPECT_EQ(first_problem("struct a_t {\n  int8_t b c;\n}"),
            "x.lcm:2:12: expected ';' after the field, got 'c'");
  EXPECT_THAT(first_problem("struct a_t { float n; int8_t b[n]; }"), HasSubstr("single integer"));
  EXPECT_THAT(first_problem("struct a_t { int8_t b[n]; int8_t n; }"), HasSubstr("declared before"));
  EXPECT_THAT(first_problem("struct a_t { int8_t b[0]; }"), HasSubstr("1 to 2^31"));
  EXPECT_THAT(first_problem("struct a_t { int8_t b; int8_t b; }"), HasSubstr("already taken"));
  EXPECT_THAT(first_problem("struct a_t { const string s = 3; }"), HasSubstr("number's type"));
  EXPECT_THAT(first_problem("struct a_t { const int8_t s = x; }"),
              HasSubstr("expected an integer"));
  EXPECT_THAT(first_problem("structure a_t { }"), HasSubstr("expected 'package'"));
  EXPECT_THAT(first_problem("struct a_t { uint8_t b; }"), HasSubstr("needs the type uint8_t"));
  EXPECT_THAT(messages(Schema(Sources{{"x.lcm", "struct a_t { int8_t b;"}})),
              ElementsAre(HasSubstr("the file ends")));
}

TEST(Schema, ATypeThatNeedsAnUnknownOneIsNoCandidateNorAreItsUsers) {
  const Schema schema(
      Sources{{"x.lcm", "struct a_t { b_t b; } struct b_t { c_t c; } struct d_t { }"}});
  EXPECT_FALSE(schema.structures()[0].complete);
  EXPECT_FALSE(schema.structures()[1].complete);
  EXPECT_TRUE(schema.structures()[2].complete);
}

TEST(Schema, TypesThatShareAFingerprintAreAllCandidatesOnce) {
  const Schema schema(Sources{{"a.lcm", "package a; struct x_t { int64_t utime; }"},
                              {"b.lcm", "package b; struct y_t { int64_t utime; }"},
                              {"copy/b.lcm", "package b; struct y_t { int64_t utime; }"}});
  EXPECT_THAT(schema.with_fingerprint(0x4d0d41c1f105b12fU), SizeIs(2));
  EXPECT_THAT(schema.with_fingerprint(1), IsEmpty());
}

TEST(Schema, ForksOfOneNameLiveSideBySideAndUseTheirNeighbours) {
  const Schema schema(Sources{{"old/in.lcm", "struct in_t { int8_t a; }"},
                              {"old/out.lcm", "struct out_t { in_t i; }"},
                              {"new/in.lcm", "struct in_t { int8_t a; int8_t b; }"},
                              {"new/out.lcm", "struct out_t { in_t i; }"}});
  const auto& types = schema.structures();
  EXPECT_EQ(types[1].members[0].structure, 0);
  EXPECT_EQ(types[3].members[0].structure, 2);
  EXPECT_NE(types[1].fingerprint, types[3].fingerprint);
  EXPECT_THAT(schema.with_fingerprint(types[1].fingerprint), ElementsAre(1));
  EXPECT_EQ(schema.find("out_t"), 3);
}

TEST(Schema, ReadsAFolderWithItsSubfoldersAndSaysWhatItCannotRead) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("marco_schema_" + std::to_string(getpid()));
  fs::create_directories(folder / "deep");
  std::ofstream(folder / "deep" / "a.lcm") << "struct a_t { }";
  std::ofstream(folder / "b.txt") << "no type";
  std::vector<Problem> problems;
  EXPECT_THAT(read_sources(folder.string(), problems), SizeIs(1));
  EXPECT_THAT(problems, IsEmpty());
  fs::remove_all(folder);
  EXPECT_THAT(read_sources(folder.string(), problems), IsEmpty());
  EXPECT_THAT(problems, SizeIs(1));
}

// 2^60 paths lead through these types; the answer must come at once, as a problem.
TEST(Schema, HostileNestingEnds) {
  std::string text = "struct t0_t { int8_t a; } ";
  for (int i = 1; i <= 60; ++i) {
    const std::string inner = "t" + std::to_string(i - 1) + "_t ";
    text += "struct t" + std::to_string(i) + "_t { " + inner + "a; " + inner + "b; } ";
  }
  const Schema schema(Sources{{"x.lcm", text}});
  EXPECT_THAT(messages(schema), ::testing::Contains(HasSubstr("nests too many types")));
}

}  // namespace
}  // namespace marco::lcm_schema
