#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "drivers/laser/laser_driver.hpp"
#include "simulator/devices/laser_world.hpp"
#include "simulator/devices/transport/simulated_line.hpp"

namespace marco::drivers {

using Bytes = std::vector<uint8_t>;

/// "02 80 0C" -> bytes.
inline Bytes hex(const std::string& text) {
  std::istringstream words(text);
  Bytes bytes;
  for (std::string word; words >> word;) {
    bytes.push_back(static_cast<uint8_t>(std::stoi(word, nullptr, 16)));
  }
  return bytes;
}

inline Bytes join(const std::vector<Bytes>& parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

inline std::vector<Bytes> split_at_random(const Bytes& bytes, std::mt19937& random) {
  std::vector<Bytes> chunks;
  std::uniform_int_distribution<std::size_t> length(1, 40);
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t count = std::min(length(random), bytes.size() - at);
    chunks.emplace_back(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                        bytes.begin() + static_cast<std::ptrdiff_t>(at + count));
    at += count;
  }
  return chunks;
}

/// What a parser made of chunks: one entry a message, comparable.
using Parse = std::function<std::vector<Bytes>(const std::vector<Bytes>&)>;

/// Damages one of eight telegrams in each of `rounds` rounds and asks that all but it and the next
/// come out, in order, and nothing else. @param messages  what parse gives for each telegram.
/// @param before  how many whole ones in front of the damage may be lost with it.
inline void expect_resynchronizes(const std::vector<Bytes>& telegrams,
                                  const std::vector<Bytes>& messages,
                                  const Parse& parse,
                                  int rounds,
                                  std::size_t before = 0) {
  std::mt19937 random(11);
  const auto any = [&random](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
  };
  for (int round = 0; round < rounds; ++round) {
    std::vector<Bytes> stream = telegrams;
    const std::size_t hurt = any(stream.size() - 2);
    Bytes& victim = stream[hurt];
    const std::size_t at = any(victim.size());
    const auto place = victim.begin() + static_cast<std::ptrdiff_t>(at);
    const auto kind = any(5);
    if (kind == 0) victim.erase(place);
    if (kind == 1) victim.insert(place, *place);
    if (kind == 2) *place = static_cast<uint8_t>(*place ^ 1u << any(8));
    if (kind == 3) victim.resize(at);
    if (kind == 4) {
      Bytes garbage(1 + any(60));
      for (uint8_t& byte : garbage) byte = static_cast<uint8_t>(any(256));
      victim.insert(place, garbage.begin(), garbage.end());
    }
    const std::vector<Bytes> got = parse(split_at_random(join(stream), random));
    std::size_t found = 0;
    int lost = 0;
    for (std::size_t i = 0; i < messages.size(); ++i) {
      if (found < got.size() && got[found] == messages[i]) {
        ++found;
      } else {
        EXPECT_TRUE(i + before >= hurt && i <= hurt + 1)
            << "round " << round << " kind " << kind << " at " << at << " lost " << i;
        ++lost;
      }
    }
    EXPECT_EQ(found, got.size()) << "round " << round << ": a message that was never sent";
    EXPECT_LE(lost, 2 + static_cast<int>(before)) << "round " << round << " kind " << kind;
  }
}

/// A world of which every beam at every time has its own range, 1.5 to 4.5 m.
inline double test_range_m(double bearing_rad, double time_s) {
  return 3.0 + std::sin(3.0 * bearing_rad) + 0.5 * std::sin(7.0 * time_s);
}

inline std::vector<double> test_world(const LaserSweep& sweep) {
  std::vector<double> ranges_m;
  for (int i = 0; i < sweep.beams; ++i) {
    ranges_m.push_back(test_range_m(sweep.first_bearing_rad + i * sweep.bearing_step_rad,
                                    sweep.first_beam.seconds() + i * sweep.beam_interval_s));
  }
  return ranges_m;
}

/// Steps the driver until `done` or for `limit_s` of simulated time; keeps its scans.
inline std::vector<ArrivedScan> step_until(
    LaserDriver& driver,
    const SimulatedLine& line,
    double limit_s,
    const std::function<bool(const std::vector<ArrivedScan>&)>& done) {
  std::vector<ArrivedScan> scans;
  const Utime limit = line.now() + Duration::from_seconds(limit_s);
  while (line.now() < limit && !done(scans)) {
    for (ArrivedScan& scan : driver.step()) scans.push_back(std::move(scan));
  }
  return scans;
}

inline std::function<bool(const std::vector<ArrivedScan>&)> have(std::size_t count) {
  return [count](const std::vector<ArrivedScan>& scans) { return scans.size() >= count; };
}

/// The largest difference of a scan's ranges to the test world's at the times the scan claims.
inline double worst_range_error_m(const LaserScan& scan) {
  double worst_m = 0.0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const auto offset_s = static_cast<double>(scan.time_offsets_s.at(i));
    const double expected_m = test_range_m(scan.bearing_rad(i), scan.utime.seconds() + offset_s);
    worst_m = std::max(worst_m, std::abs(static_cast<double>(scan.ranges_m[i]) - expected_m));
  }
  return worst_m;
}

}  // namespace marco::drivers
