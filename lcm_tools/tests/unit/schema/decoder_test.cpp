#include "lcm_tools/schema/decoder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "lcm_tools/schema/built_in_sources.hpp"
#include "lcm_tools/schema/json.hpp"
#include "marco/process_status_t.hpp"
#include "schema_test/inner/all_t.hpp"
#include "schema_test/inner/tree_t.hpp"

namespace marco::lcm_schema {
namespace {

using Sources = std::vector<Source>;

using schema_test::inner::all_t;
using schema_test::inner::tree_t;

template <class Message>
std::vector<uint8_t> encoded(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

const Schema& test_schema() {
  static const Schema kSchema = [] {
    std::vector<Problem> problems;
    std::vector<Source> sources = read_sources("tests/unit/schema/test_types.lcm", problems);
    for (Source& source : built_in_sources()) sources.push_back(std::move(source));
    return Schema(sources);
  }();
  return kSchema;
}

all_t example() {
  all_t message = {};
  message.rows = 2;
  message.cols = 3;
  message.one.n = 2;
  message.one.names = {"first", "sec\"ond\n"};
  message.many.assign(2, std::vector<schema_test::inner::pair_t>(2));
  message.many[1][0].n = 1;
  message.many[1][0].names = {"deep"};
  message.matrix.assign(3, {0.1, -2, 1e300});
  message.matrix[2][1] = NAN;
  message.ok = 1;
  message.flags[1] = 1;
  for (int i = 0; i < 16; ++i) message.raw[i] = static_cast<uint8_t>(250 + i);
  message.f = 0.1F;
  message.big = INT64_MIN;
  message.text =
      "Gr\xC3\xBC\xC3\x9F"
      "e \xFF";
  message.fixed.resize(3);
  message.fixed[2].y[1] = -7;
  return message;
}

struct Decoded {
  explicit Decoded(std::vector<uint8_t> message, const char* type = "all_t")
      : bytes(std::move(message)), decoder(test_schema()) {
    const int index = *test_schema().find(type);
    status = decoder.decode(index, bytes, tree);
    EXPECT_EQ(decoder.check(index, bytes), status);
  }
  std::vector<uint8_t> bytes;
  Decoder decoder;
  Tree tree;
  DecodeStatus status;
};

TEST(Decoder, EveryFieldIsFoundByItsPath) {
  const Decoded d(encoded(example()));
  ASSERT_EQ(d.status, DecodeStatus::ok);
  const auto node = [&](const char* path) -> const Node& {
    const int index = d.tree.find(path);
    EXPECT_GE(index, 0) << path;
    EXPECT_EQ(d.tree.path(index), path);
    return d.tree.nodes[static_cast<std::size_t>(std::max(index, 0))];
  };
  EXPECT_EQ(d.tree.integer(node("rows")), 2);
  EXPECT_EQ(d.tree.text(node("one.names[1]")), "sec\"ond\n");
  EXPECT_EQ(d.tree.number(node("matrix"), 8), 1e300);
  EXPECT_EQ(d.tree.number(node("matrix"), 3), 0.1);
  EXPECT_EQ(d.tree.integer(node("flags"), 1), 1);
  EXPECT_EQ(d.tree.integer(node("raw"), 5), 255);
  EXPECT_FLOAT_EQ(static_cast<float>(d.tree.number(node("f"))), 0.1F);
  EXPECT_EQ(d.tree.integer(node("big")), INT64_MIN);
  EXPECT_EQ(d.tree.integer(node("fixed[2].y"), 1), -7);
  EXPECT_EQ(node("many").count, 4U);
  EXPECT_EQ(d.tree.text(node("many[2].names[0]")), "deep");
  EXPECT_EQ(d.tree.find("fixed[3]"), -1);
  EXPECT_EQ(d.tree.find("fixed[x].y"), -1);
  EXPECT_EQ(d.tree.find("fixed["), -1);
  EXPECT_EQ(d.tree.find("nothing.here"), -1);
  EXPECT_EQ(d.tree.find("rows.here"), -1);
  const int matrix = d.tree.find("matrix");
  EXPECT_EQ(value_name(d.tree, matrix, 5), "matrix[1][2]");
  std::size_t values = 0;
  for_each_value(d.tree, [&](int, std::size_t) { ++values; });
  EXPECT_EQ(values, 2U + 3 + 4 + 1 + 9 + 1 + 2 + 16 + 3 + 9);
}

TEST(Decoder, JsonReadsBackToTheSameValues) {
  const Decoded d(encoded(example()));
  std::string text;
  append_json(d.tree, text);
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["one"]["names"][1], "sec\"ond\n");
  EXPECT_EQ(json["many"][1][0]["names"][0], "deep");
  EXPECT_EQ(json["many"][0].size(), 2U);
  EXPECT_EQ(json["matrix"][0], (std::vector<double>{0.1, -2, 1e300}));
  EXPECT_TRUE(json["matrix"][2][1].is_null());
  EXPECT_EQ(json["ok"], true);
  EXPECT_EQ(json["raw"][15], 9);
  EXPECT_EQ(json["f"].dump(), "0.1");
  EXPECT_EQ(json["big"], INT64_MIN);
  EXPECT_EQ(json["text"],
            "Gr\xC3\xBC\xC3\x9F"
            "e \xEF\xBF\xBD");
  EXPECT_EQ(json["fixed"][2]["y"], (std::vector<int>{0, -7}));
}

TEST(Decoder, JsonCutsLongArraysAndWritesBytesAsText) {
  const Decoded d(encoded(example()));
  std::string text;
  JsonOptions options;
  options.max_elements = 2;
  options.bytes_as_base64 = true;
  append_json(d.tree, text, options);
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["raw"], "+vv8/f7/AAECAwQFBgcICQ==");
  EXPECT_EQ(json["matrix"].dump(),
            "[[0.1,-2,\"... 1 more\"],[0.1,-2,\"... 1 more\"],\"... 1 more\"]");
  EXPECT_EQ(json["fixed"][2], "... 1 more");
  EXPECT_EQ(json["fixed"].size(), 3U);
  const auto schema =
      nlohmann::json::parse(json_schema(test_schema(), *test_schema().find("all_t"), options));
  EXPECT_EQ(schema["properties"]["raw"]["contentEncoding"], "base64");
  EXPECT_EQ(schema["properties"]["many"]["items"]["items"]["properties"]["n"]["type"], "integer");
  EXPECT_EQ(schema["properties"]["matrix"]["items"]["items"]["type"], "number");
}

TEST(Decoder, ATypeInsideItselfIsFollowed) {
  tree_t message = {};
  message.n = 2;
  message.kids.resize(2);
  message.kids[1].n = 1;
  message.kids[1].kids.resize(1);
  message.kids[1].kids[0].value = 42;
  const Decoded d(encoded(message), "tree_t");
  ASSERT_EQ(d.status, DecodeStatus::ok);
  EXPECT_EQ(
      d.tree.integer(d.tree.nodes[static_cast<std::size_t>(d.tree.find("kids[1].kids[0].value"))]),
      42);
}

TEST(Decoder, DeepNestingIsRefused) {
  std::vector<uint8_t> bytes = encoded(tree_t{});
  bytes.resize(8);
  bytes.resize(8 + 1000, 1);  // every n is 1: a chain of 1000 kids
  EXPECT_EQ(Decoded(bytes, "tree_t").status, DecodeStatus::too_deep);
}

TEST(Decoder, EveryShorterMessageIsTruncatedAndForeignBytesAreRefused) {
  const std::vector<uint8_t> bytes = encoded(example());
  for (std::size_t size = 8; size < bytes.size(); ++size) {
    const Decoded d({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    EXPECT_EQ(d.status, DecodeStatus::truncated) << size;
    EXPECT_TRUE(d.tree.nodes.empty());
  }
  EXPECT_EQ(Decoded({bytes.begin(), bytes.begin() + 7}).status, DecodeStatus::wrong_fingerprint);
  EXPECT_EQ(Decoded(bytes, "tree_t").status, DecodeStatus::wrong_fingerprint);
  std::vector<uint8_t> longer = bytes;
  longer.push_back(0);
  EXPECT_EQ(Decoded(longer).status, DecodeStatus::ok);  // as lcm-gen's decoders do
}

TEST(Decoder, NegativeAndHugeLengthsAreRefused) {
  std::vector<uint8_t> bytes = encoded(bot_core::planar_lidar_t{});
  bytes[16] = 0x80;
  EXPECT_EQ(Decoded(bytes, "planar_lidar_t").status, DecodeStatus::bad_length);
  bytes[16] = 0x7F;
  EXPECT_EQ(Decoded(bytes, "planar_lidar_t").status, DecodeStatus::truncated);
  const Schema schema(Sources{{"x.lcm", "struct e_t { } struct a_t { int64_t n; e_t e[n][n]; }"}});
  const Decoder decoder(schema);
  std::vector<uint8_t> many(16, 0x7F);
  for (std::size_t i = 0; i < 8; ++i)
    many[i] = static_cast<uint8_t>(schema.structures()[1].fingerprint >> (56 - 8 * i));
  Tree tree;
  EXPECT_EQ(decoder.decode(1, many, tree), DecodeStatus::too_large);
  EXPECT_EQ(decoder.check(1, many), DecodeStatus::ok);  // no byte is missing
}

// Oracle: the compiled decoders. Fields before the damage decide, so both must agree on every
// message. (Types whose damaged lengths make the compiled code allocate gigabytes are left out.)
template <class Message>
void compare_with_compiled(const Message& message, const char* type, unsigned seed) {
  std::mt19937 random(seed);
  const std::vector<uint8_t> whole = encoded(message);
  const Decoder decoder(test_schema());
  const int index = *test_schema().find(type);
  Tree tree;
  int agreed_good = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<uint8_t> bytes = whole;
    for (auto flips = random() % 3; flips > 0; --flips) {
      bytes[8 + random() % (bytes.size() - 8)] = static_cast<uint8_t>(random());
    }
    if (random() % 4 == 0) bytes.resize(8 + random() % (bytes.size() - 7));
    Message twin;
    bool good = false;
    try {
      good = twin.decode(bytes.data(), 0, static_cast<int>(bytes.size())) >= 0;
    } catch (const std::exception&) {  // a string's length below 1
    }
    const DecodeStatus status = decoder.decode(index, bytes, tree);
    ASSERT_EQ(decoder.check(index, bytes), status);
    ASSERT_EQ(status == DecodeStatus::ok, good) << name_of(status) << " in round " << round;
    agreed_good += good ? 1 : 0;
  }
  EXPECT_GT(agreed_good, 100);
  EXPECT_LT(agreed_good, 3000);
}

TEST(Decoder, AgreesWithLcmGensDecodersOnDamagedMessages) {
  compare_with_compiled(bot_core::pose_t{}, "pose_t", 1);
  process_status_t info = {};
  info.process = "A_CHANNEL_WITH_A_NAME_LONG_ENOUGH_TO_BE_DAMAGED";
  compare_with_compiled(info, "process_status_t", 2);
}

// Any bytes behind the fingerprint: nothing but a status may come of it (run under ASan in CI).
TEST(Decoder, SurvivesAnyBytes) {
  std::mt19937 random(7);
  const Decoder decoder(test_schema());
  const std::vector<uint8_t> good = encoded(example());
  Tree tree;
  std::string json;
  int decoded = 0;
  for (int round = 0; round < 20000; ++round) {
    std::vector<uint8_t> bytes = good;
    for (auto flips = 1 + random() % 4; flips > 0; --flips) {
      bytes[8 + random() % (bytes.size() - 8)] =
          static_cast<uint8_t>(random() % 3 == 0 ? random() : random() % 4);
    }
    bytes.resize(8 + random() % (bytes.size() + 20));
    const int index = *test_schema().find("all_t");
    const DecodeStatus status = decoder.decode(index, bytes, tree);
    ASSERT_EQ(decoder.check(index, bytes), status);
    if (status != DecodeStatus::ok) continue;
    ++decoded;
    json.clear();
    append_json(tree, json);
    ASSERT_TRUE(nlohmann::json::accept(json)) << json;
  }
  EXPECT_GT(decoded, 100);
}

// The sizes of an array that is empty inside are said, as long as they are believable.
TEST(Json, AnArrayThatIsEmptyInsideKeepsItsOuterBrackets) {
  const Schema schema(Sources{{"e.lcm",
                               "struct x_t { int8_t v; } struct e_t { int32_t n, m; "
                               "double a[n][m]; x_t b[n][m]; byte c[2][n][m]; }"}});
  const auto json_of = [&](int32_t n, int32_t m) {
    const int type = *schema.find("e_t");
    std::vector<uint8_t> bytes;
    const uint64_t fingerprint = schema.structures()[static_cast<std::size_t>(type)].fingerprint;
    for (unsigned i = 8; i > 0; --i)
      bytes.push_back(static_cast<uint8_t>(fingerprint >> (8 * (i - 1))));
    for (const int32_t value : {n, m}) {
      for (unsigned i = 4; i > 0; --i)
        bytes.push_back(static_cast<uint8_t>(static_cast<uint32_t>(value) >> (8 * (i - 1))));
    }
    const Decoder decoder(schema);
    Tree tree;
    EXPECT_EQ(decoder.decode(type, bytes, tree), DecodeStatus::ok);
    std::string text;
    append_json(tree, text);
    return text;
  };
  EXPECT_EQ(json_of(2, 0), R"({"n":2,"m":0,"a":[[],[]],"b":[[],[]],"c":[[[],[]],[[],[]]]})");
  EXPECT_EQ(json_of(0, 2), R"({"n":0,"m":2,"a":[],"b":[],"c":[[],[]]})");
  EXPECT_EQ(json_of(INT32_MAX, 0), R"({"n":2147483647,"m":0,"a":[],"b":[],"c":[]})");
}

}  // namespace
}  // namespace marco::lcm_schema
