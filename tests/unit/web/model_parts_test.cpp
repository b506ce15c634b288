#include "web/model_parts.hpp"

#include <gmock/gmock.h>

#include "marco/mesh_t.hpp"
#include "marco/slam_pose_t.hpp"

namespace marco::web {
namespace {

using process::RawMessage;
using testing::ElementsAre;
using testing::IsEmpty;

template <class Message>
std::vector<uint8_t> encoded(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, message.getEncodedSize());
  return bytes;
}

std::vector<uint8_t> tile(int64_t revision, int32_t number) {
  mesh_t mesh{};
  mesh.revision = revision;
  mesh.tile = number;
  return encoded(mesh);
}

std::vector<int32_t> given(ModelParts& parts, int most) {
  std::vector<int32_t> numbers;
  parts.give(most, [&](const RawMessage& message) {
    mesh_t mesh{};
    mesh.decode(message.bytes.data(), 0, static_cast<int>(message.bytes.size()));
    numbers.push_back(mesh.tile);
  });
  return numbers;
}

TEST(ModelParts, WaitForTheirTurnInOrder) {
  ModelParts parts;
  for (const int32_t number : {0, 1, 2}) EXPECT_TRUE(parts.put({"MESH", tile(1, number), {}}));
  EXPECT_THAT(given(parts, 2), ElementsAre(0, 1));
  EXPECT_THAT(given(parts, 2), ElementsAre(2));
  EXPECT_THAT(given(parts, 2), IsEmpty());
}

TEST(ModelParts, OfAnEarlierModelAreNotGivenAnyMore) {
  ModelParts parts;
  parts.put({"MESH", tile(1, 0), {}});
  parts.put({"OTHER", tile(1, 7), {}});
  parts.put({"MESH", tile(2, 5), {}});
  EXPECT_THAT(given(parts, 9), ElementsAre(7, 5));
}

TEST(ModelParts, KeepNoOtherMessageAndNoMoreThanTheyHaveRoomFor) {
  ModelParts parts;
  EXPECT_FALSE(parts.put({"SLAM_POSE", encoded(slam_pose_t{}), {}}));
  EXPECT_FALSE(parts.put({"MESH", std::vector<uint8_t>(8, 0), {}}));
  auto large = tile(1, 0);
  large.resize(ModelParts::kMostBytes / 2);
  EXPECT_TRUE(parts.put({"MESH", large, {}}));
  EXPECT_TRUE(parts.put({"MESH", large, {}}));
  EXPECT_FALSE(parts.put({"MESH", tile(1, 3), {}}));
}

}  // namespace
}  // namespace marco::web
