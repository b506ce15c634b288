#include "mapping3d/surface/surface_bound.hpp"

#include <gtest/gtest.h>

namespace marco::mapping3d {
namespace {

// A square of 1 m and an ear at its side, 2 or 20 mm wide, that a step cuts off.
TEST(SurfaceBound, LeavesNoSampleUncovered) {
  for (const float width_m : {0.002F, 0.02F}) {
    TriangleMesh mesh;
    mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1 + width_m, 0.5F, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}};
    SurfaceBound bound(mesh, {0, 0, 0}, {}, 0.005F, 1e-4F);
    SurfaceBound::Step step;
    step.replaced = {{2, {mesh.vertices_m[1], mesh.vertices_m[4], mesh.vertices_m[2]}}};
    step.beside = {{0, {mesh.vertices_m[0], mesh.vertices_m[1], mesh.vertices_m[2]}}};
    EXPECT_EQ(bound.allows(step), width_m < 0.005F);
  }
}

// The same square, a corner of which is pulled out in its plane.
TEST(SurfaceBound, MakesNothingWhereNothingWas) {
  TriangleMesh mesh;
  mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  SurfaceBound bound(mesh, {0, 0}, {}, 0.005F, 1e-4F);
  for (const float pulled_m : {0.002F, 0.02F}) {
    SurfaceBound::Step step;
    step.replaced = {{0, {mesh.vertices_m[0], mesh.vertices_m[1], mesh.vertices_m[2]}}};
    step.made = {{0, {mesh.vertices_m[0], {1 + pulled_m, -pulled_m, 0}, mesh.vertices_m[2]}}};
    EXPECT_EQ(bound.allows(step), pulled_m < 0.005F);
  }
}

// A roof of four triangles about a middle that lies on their plane, 4 mm from the original.
class BoundOnAPlane : public ::testing::Test {
 protected:
  BoundOnAPlane()
      : bound_(original(), {0.004F, 0.004F, 0.004F, 0.004F}, {1, 1, 1, 1}, 0.01F, 1e-4F) {}

  const TriangleMesh& original() {
    mesh_.vertices_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5F, 0.5F, 0.004F}};
    mesh_.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
    return mesh_;
  }
  static Eigen::Vector3f flat(Eigen::Vector3f at_m) { return {at_m.x(), at_m.y(), 0}; }
  SurfaceBound::Corners laid(uint32_t triangle) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    const auto& at_m = mesh_.vertices_m;
    return {triangle, {flat(at_m[a]), flat(at_m[b]), flat(at_m[c])}};
  }
  /// The middle moves onto corner 0.
  SurfaceBound::Step middle_away() const {
    SurfaceBound::Step step;
    step.vanishes_m = flat(mesh_.vertices_m[4]);
    for (uint32_t t = 0; t < 4; ++t) step.replaced.push_back(laid(t));
    step.made = {{1, {mesh_.vertices_m[1], mesh_.vertices_m[2], mesh_.vertices_m[0]}},
                 {2, {mesh_.vertices_m[2], mesh_.vertices_m[3], mesh_.vertices_m[0]}}};
    step.fills_the_ring = step.stays_on_plane = true;
    return step;
  }
  /// Corner 2 is drawn inwards, which leaves a strip of the square bare.
  SurfaceBound::Step corner_in(float by_m) const {
    SurfaceBound::Step step;
    step.replaced = {{1, {mesh_.vertices_m[1], mesh_.vertices_m[2], mesh_.vertices_m[0]}}};
    step.made = {{1, {mesh_.vertices_m[1], {1 - by_m, 1 - by_m, 0}, mesh_.vertices_m[0]}}};
    return step;
  }

  TriangleMesh mesh_;
  SurfaceBound bound_;
};

TEST_F(BoundOnAPlane, IsSampledOnceAStepTakesAPartAway) {
  ASSERT_TRUE(bound_.allows(middle_away()));
  bound_.take(middle_away());
  // Of the 10 mm 4 are spent: the plane stands for what lies that far from it.
  EXPECT_FALSE(bound_.allows(corner_in(0.02F)));
  EXPECT_FALSE(bound_.allows(corner_in(0.005F)));
  EXPECT_TRUE(bound_.allows(corner_in(0.002F)));
}

TEST_F(BoundOnAPlane, ASampledNeighbourTakesSamplesOver) {
  SurfaceBound::Step step;
  step.replaced = {laid(0)};
  step.beside = {laid(1), laid(3)};
  EXPECT_FALSE(bound_.allows(step));  // a quarter of the square would be bare
  ASSERT_TRUE(bound_.allows(middle_away()));
  bound_.take(middle_away());
  const auto corners_m = [&](std::size_t t) {
    return t == 1 ? middle_away().made[0].at_m : middle_away().made[1].at_m;
  };
  EXPECT_NEAR(bound_.largest_m(corners_m), 0.004, 1e-5);
}

}  // namespace
}  // namespace marco::mapping3d
