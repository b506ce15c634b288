#include "mapping3d/surface/picture_gains.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "common/median.hpp"

namespace marco::mapping3d {
namespace {

constexpr float kDarkest = 16.0F, kBrightest = 245.0F;  // beyond, values are not proportional
constexpr std::size_t kFewestOfPair = 10;               // of points, for a median
constexpr std::size_t kMostOfPair = 128;                // of points; bounds memory: 1.5 kB a pair
constexpr std::size_t kMostPartners = 8;                // of the looks at a point, for pairs
// Standard deviations of logarithms.
constexpr double kPointSigma = 0.1;   // of a point's ratio: noise, texture seen half a pixel off
constexpr double kPairSigma = 0.05;   // of a pair's, however many its points: gloss, light
constexpr double kPriorSigma = 0.3;   // of a gain: cameras differ by a third of a stop or so
constexpr double kHuberSigmas = 2.0;  // beyond, a pair weighs less

using Pair = std::pair<uint32_t, uint32_t>;
using Ratios = std::array<std::vector<float>, 3>;  // logarithms of first over second, by channel

// Points in an order that spreads any first part of them over the whole surface.
template <class Visit>
void for_each_spread(std::size_t count, const Visit& visit) {
  // Multiples of a prime that does not divide the count meet each once; near the golden section
  // of 1e6, so that those that follow each other lie far apart.
  constexpr std::size_t kPrime = 618041;
  const std::size_t step = count % kPrime == 0 ? 1 : kPrime;
  for (std::size_t i = 0, at = 0; i < count; ++i, at = (at + step) % count) visit(at);
}

void add_ratios(const Look& a, const Look& b, std::map<Pair, Ratios>& ratios) {
  const bool in_order = a.view < b.view;
  Ratios& of_pair = ratios[in_order ? Pair(a.view, b.view) : Pair(b.view, a.view)];
  for (int channel = 0; channel < 3; ++channel) {
    auto& values = of_pair[static_cast<std::size_t>(channel)];
    const float first = in_order ? a.rgb[channel] : b.rgb[channel];
    const float second = in_order ? b.rgb[channel] : a.rgb[channel];
    const bool usable =
        std::min(first, second) >= kDarkest && std::max(first, second) <= kBrightest;
    if (usable && values.size() < kMostOfPair) values.push_back(std::log(first / second));
  }
}

std::map<Pair, Ratios> ratios_of_pairs(const SurfaceLooks& seen) {
  std::map<Pair, Ratios> ratios;
  for_each_spread(seen.points.size(), [&](std::size_t at) {
    const std::span<const Look> looks = seen.of(seen.points[at]);
    const std::size_t count = std::min(looks.size(), kMostPartners);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = i + 1; j < count; ++j) add_ratios(looks[i], looks[j], ratios);
    }
  });
  return ratios;
}

struct Link {
  uint32_t first, second;
  double log_ratio;
  double sigma;
};

std::vector<Link> links_of(const std::map<Pair, Ratios>& ratios, std::size_t channel) {
  std::vector<Link> links;
  for (const auto& [pair, of_pair] : ratios) {
    const std::vector<float>& values = of_pair[channel];
    if (values.size() < kFewestOfPair) continue;
    const double sigma =
        std::hypot(kPairSigma, kPointSigma / std::sqrt(static_cast<double>(values.size())));
    links.push_back({pair.first, pair.second, static_cast<double>(median(values)), sigma});
  }
  return links;
}

// Minimizes sum ((g_i - g_j + ratio) / sigma)^2 + sum (g_i / prior)^2, links weighted by Huber.
Eigen::VectorXd solve(const std::vector<Link>& links, std::size_t views) {
  constexpr int kRounds = 5;  // of reweighting
  const auto count = static_cast<Eigen::Index>(views);
  Eigen::VectorXd gains = Eigen::VectorXd::Zero(count);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      entries.emplace_back(i, i, 1.0 / (kPriorSigma * kPriorSigma));
    }
    for (const Link& link : links) {
      const double off =
          std::abs(gains[link.first] - gains[link.second] + link.log_ratio) / link.sigma;
      const double huber = round > 0 && off > kHuberSigmas ? kHuberSigmas / off : 1.0;
      const double weight = huber / (link.sigma * link.sigma);
      entries.emplace_back(link.first, link.first, weight);
      entries.emplace_back(link.second, link.second, weight);
      entries.emplace_back(link.first, link.second, -weight);
      entries.emplace_back(link.second, link.first, -weight);
      right[link.first] -= weight * link.log_ratio;
      right[link.second] += weight * link.log_ratio;
    }
    Eigen::SparseMatrix<double> normal(count, count);
    normal.setFromTriplets(entries.begin(), entries.end());
    gains = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal).solve(right);
  }
  return gains;
}

}  // namespace

std::vector<Eigen::Vector3f> picture_gains(const SurfaceLooks& seen, std::size_t views) {
  constexpr double kMostLog = 1.386;  // a factor of 4
  std::vector<Eigen::Vector3f> gains(views, Eigen::Vector3f::Ones());
  if (views < 2) return gains;
  const std::map<Pair, Ratios> ratios = ratios_of_pairs(seen);
  for (int channel = 0; channel < 3; ++channel) {
    const Eigen::VectorXd logs = solve(links_of(ratios, static_cast<std::size_t>(channel)), views);
    for (std::size_t view = 0; view < views; ++view) {
      const double log = logs[static_cast<Eigen::Index>(view)];
      gains[view][channel] = static_cast<float>(std::exp(std::clamp(log, -kMostLog, kMostLog)));
    }
  }
  return gains;
}

}  // namespace marco::mapping3d
