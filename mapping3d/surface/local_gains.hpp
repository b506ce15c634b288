#pragma once

#include <array>
#include <span>
#include <unordered_map>
#include <vector>

#include "mapping3d/surface/surface_looks.hpp"

namespace marco::mapping3d {

/// The low frequencies of a texture. Pictures of a place differ by its gloss, by lamps the camera
/// carries and by vignetting, all of them smooth: in the low frequencies all pictures mix, by
/// merit; in the high ones the best alone counts (two bands of Burt and Adelson, A Multiresolution
/// Spline, 1983; for textures Baumberg, Blending Images for Texturing 3D Models, BMVC 2002). What
/// differs: the low band is no blurred picture, which would carry colours across edges of depth,
/// but a gain for each picture, smooth along the surface, that makes it equal to the mean of all.
/// It lives in a lattice of cubes for each of the six facings, linear in between.
/// Cost O(looks of the surface); memory 28 bytes for each cube and picture that sees it.
class LocalGains {
 public:
  /// @param seen  with gains of whole pictures applied; points that nobody sees are to be filled
  explicit LocalGains(const SurfaceLooks& seen);

  /// What a place is multiplied with and filled by: the cubes about it.
  class Place {
   public:
    /// 1 where nothing is known of the picture. Each channel for itself.
    Eigen::Vector3f gain(uint32_t view) const;
    /// The mean colour of the pictures, or where nobody sees, what spreads from the cubes around
    /// with the same facing (solution of Laplace's equation).
    Eigen::Vector3f colour() const;
    /// False where no colour is or spreads: colour() is then the mean of all with this facing.
    bool reached() const;

   private:
    friend class LocalGains;
    const LocalGains* field_ = nullptr;
    std::array<int, 8> cubes_{};  // -1: none
    std::array<float, 8> weights_{};
  };
  Place at(const Eigen::Vector3f& point_m, int facing) const;

 private:
  struct OfView {
    uint32_t view = 0;
    Eigen::Vector3f wanted = Eigen::Vector3f::Zero();  // sums over points
    Eigen::Vector3f shown = Eigen::Vector3f::Zero();
  };
  struct Cube {
    std::vector<OfView> views;
    Eigen::Vector3f colour = Eigen::Vector3f::Zero();  // a sum, then the mean
    float weight = 0.0F;
    bool reached = false;  // by a colour
  };
  using Key = uint64_t;
  static Key key_of(const Eigen::Vector3i& cell, int facing);
  template <class Visit>
  void for_each_corner(const Eigen::Vector3f& point_m, const Visit& visit) const;
  void add(const SurfaceLooks::Point& point, std::span<const Look> looks);
  Eigen::Vector3f mean_colour(int facing) const;
  std::vector<std::size_t> neighbours(std::size_t cube) const;
  Eigen::Vector3f mean_around(std::size_t cube) const;
  std::vector<std::size_t> spread();
  void fill();

  float edge_m_;
  std::unordered_map<Key, int> cube_of_;
  std::vector<Cube> cubes_;
  std::vector<std::pair<Eigen::Vector3i, int>> cells_;  // of the cubes, with their facing
  std::vector<float> shares_;                           // of a vote
};

}  // namespace marco::mapping3d
