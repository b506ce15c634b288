// A real log cut in three: mapped in sessions that go on with each other's map, and as separate
// maps merged afterwards.
#include <gtest/gtest.h>

#include <cstdio>

#include "slam/session/mapping_session.hpp"
#include "slam/session/merge_maps.hpp"
#include "tests/support/localization_recorded.hpp"
#include "tests/support/real_data.hpp"

namespace marco::slam {
namespace {

class SessionsInIntel : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = marco::testing::real_data();
    if (folder == nullptr) GTEST_SKIP();
    const std::string intel = std::string(folder) + "/intel/intel";
    inputs_ = testing::read_carmen_scans(intel + ".log");
    relations_ = files::read_relations(intel + ".relations");
    MappingSession whole({}, {});
    map(whole, 0, inputs_.size());
    single_ = error_of(whole.saved(""));
  }
  void map(MappingSession& session, std::size_t first, std::size_t end) const {
    for (std::size_t i = first; i < end; ++i) session.process(inputs_[i]);
    session.finish();
  }
  SavedMap third(MappingSession& session, std::size_t index) const {
    map(session, inputs_.size() * index / 3, inputs_.size() * (index + 1) / 3);
    return session.saved("");
  }
  RelationsError error_of(const SavedMap& map) const {
    Slam slam;
    slam.restore(map.slam);
    return compare_with_relations(slam.trajectory(), relations_).all;
  }
  void expect_as_good(const char* name, const SavedMap& map) const {
    const RelationsError error = error_of(map);
    std::printf(
        "intel in three, %s: %zu relations, mean %.4f m, %.3f deg; in one %.4f m, %.3f deg\n", name,
        error.count, error.translation_m.mean, error.rotation_deg.mean, single_.translation_m.mean,
        single_.rotation_deg.mean);
    EXPECT_EQ(error.count, single_.count);
    EXPECT_LE(error.translation_m.mean, 1.1 * single_.translation_m.mean);
    EXPECT_LE(error.rotation_deg.mean, 1.1 * single_.rotation_deg.mean);
  }
  std::vector<SlamInput> inputs_;
  std::vector<PoseRelation> relations_;
  RelationsError single_;
};

TEST_F(SessionsInIntel, ExtendedTwiceTheMapIsAsGoodAsOfOneRun) {
  MappingSession session({}, {});
  SavedMap map = third(session, 0);
  for (const std::size_t index : {1U, 2U}) {
    session.extend(map);
    map = third(session, index);
    ASSERT_TRUE(session.joined()) << index;
  }
  expect_as_good("extended", map);
}

TEST_F(SessionsInIntel, MergedTheMapIsAsGoodAsOfOneRun) {
  std::vector<SavedMap> maps;
  for (const std::size_t index : {0U, 1U, 2U}) {
    MappingSession session({}, {});
    maps.push_back(third(session, index));
  }
  std::vector<std::size_t> not_found;
  const SavedMap merged = merge_maps(std::move(maps), {}, {}, not_found);
  EXPECT_TRUE(not_found.empty());
  expect_as_good("merged", merged);
}

}  // namespace
}  // namespace marco::slam
