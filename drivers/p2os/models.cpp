#include "drivers/p2os/models.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>

namespace marco::drivers::p2os {
namespace {

/// Of a sonar in the robot frame; all 0: not fitted.
struct Place {
  int x_mm, y_mm, deg;
};
using Row = std::array<Place, 8>;  // as many hang at a board

// clang-format off
constexpr Row kFront{{{69, 136, 90}, {114, 119, 50}, {148, 78, 30}, {166, 27, 10},
                      {166, -27, -10}, {148, -78, -30}, {114, -119, -50}, {69, -136, -90}}};
constexpr Row kRear{{{-157, -136, -90}, {-203, -119, -130}, {-237, -78, -150}, {-255, -27, -170},
                     {-255, 27, 170}, {-237, 78, 150}, {-203, 119, 130}, {-157, 136, 90}}};
constexpr Row kFrontAbove{{{-20, 136, 90}, {24, 119, 50}, {58, 78, 30}, {77, 27, 10},
                           {77, -27, -10}, {58, -78, -30}, {24, -119, -50}, {-20, -136, -90}}};
constexpr Row kRearAbove{{{-191, -136, -90}, {-237, -119, -130}, {-271, -78, -150}, {-290, -27, -170},
                          {-290, 27, 170}, {-271, 78, 150}, {-237, 119, 130}, {-191, 136, 90}}};
constexpr Row kFrontAt{{{147, 136, 90}, {193, 119, 50}, {227, 79, 30}, {245, 27, 10},
                        {245, -27, -10}, {227, -79, -30}, {193, -119, -50}, {147, -136, -90}}};
constexpr Row kRearAt{{{-144, -136, -90}, {-189, -119, -130}, {-223, -79, -150}, {-241, -27, -170},
                       {-241, 27, 170}, {-223, 79, 150}, {-189, 119, 130}, {-144, 136, 90}}};
constexpr Row kFrontPatrol{{{83, 229, 90}, {169, 202, 55}, {232, 134, 30}, {263, 46, 10},
                            {263, -46, -10}, {232, -134, -30}, {169, -202, -55}, {83, -229, -90}}};
constexpr Row kRearPatrol{{{-83, -229, -90}, {-169, -202, -125}, {-232, -134, -150}, {-263, -46, -170},
                           {-263, 46, 170}, {-232, 134, 150}, {-169, 202, 125}, {-83, 229, 90}}};
constexpr Row kAmigo{{{76, 100, 90}, {125, 75, 41}, {150, 30, 15}, {150, -30, -15},
                      {125, -75, -41}, {76, -100, -90}, {-140, -58, -145}, {-140, 58, 145}}};
constexpr Row kAmigoSh{{{70, 100, 90}, {125, 75, 41}, {144, 30, 15}, {144, -30, -15},
                        {120, -75, -41}, {70, -100, -90}, {-146, -58, -145}, {-146, 58, 145}}};
constexpr Row kFrontLeftPower{{{152, 278, 90}, {200, 267, 65}, {241, 238, 45}, {274, 200, 35},
                               {300, 153, 25}, {320, 96, 15}, {332, 33, 5}, {0, 0, 0}}};
constexpr Row kFrontRightPower{{{332, -33, -5}, {320, -96, -15}, {300, -153, -25}, {274, -200, -35},
                                {241, -238, -45}, {200, -267, -65}, {152, -278, -90}, {0, 0, 0}}};
constexpr Row kRearRightPower{{{-298, -278, -90}, {-347, -267, -115}, {-388, -238, -135}, {-420, -200, -145},
                               {-447, -153, -155}, {-467, -96, -165}, {-478, -33, -175}, {0, 0, 0}}};
constexpr Row kRearLeftPower{{{-478, 33, 175}, {-467, 96, 165}, {-447, 153, 155}, {-420, 200, 145},
                              {-388, 238, 135}, {-347, 267, 115}, {-298, 278, 90}, {0, 0, 0}}};
// clang-format on

using Rows = std::array<const Row*, 4>;
constexpr Rows kDx{&kFront, &kRear};
constexpr Rows kAt{&kFrontAt, &kRearAt};
constexpr Rows kPatrol{&kFrontPatrol, &kRearPatrol};
constexpr Rows kPeople2{&kFront, &kFrontAbove, &kRear};
constexpr Rows kPeople{&kFront, &kFrontAbove, &kRear, &kRearAbove};
constexpr Rows kPeopleSh{&kFront, &kRear, &kFrontAbove, &kRearAbove};
constexpr Rows kPower{&kFrontLeftPower, &kFrontRightPower, &kRearRightPower, &kRearLeftPower};
constexpr Rows kPowerRear{&kRearRightPower, &kRearLeftPower};

struct Entry {
  const char* subtype;  // lower case
  double distance, range, difference, velocity;
  Rows rows;
};
constexpr Entry kEntries[] = {
    {"amigo", 0.5083, 1.0, 0.011, 0.6154, {&kAmigo}},
    {"amigo-sh", 1.0, 1.0, 0.011, 1.0, {&kAmigoSh}},
    {"mt400", 1.0, 1.0, 0.0056, 1.0, kPatrol},
    {"p2at", 1.32, 0.268, 0.0034, 1.0, kAt},
    {"p2at8", 1.32, 1.0, 0.0034, 1.0, kAt},
    {"p2at8+", 0.465, 1.0, 0.0034, 1.0, kAt},
    {"p2ce", 0.826, 0.268, 0.0057, 1.0, kDx},
    {"p2d8", 0.485, 1.0, 0.0056, 1.0, kDx},
    {"p2d8+", 0.485, 1.0, 0.0056, 1.0, kDx},
    {"p2de", 0.969, 0.268, 0.0056, 1.0, kDx},
    {"p2df", 0.485, 0.268, 0.0060, 1.0, kDx},
    {"p2dx", 0.84, 0.268, 0.0056, 1.0, kDx},
    {"p2it", 1.136, 0.268, 0.0032, 1.0, kAt},
    {"p2pb", 0.424, 0.268, 0.0056, 1.0, kPeople2},
    {"p2pp", 0.485, 0.268, 0.0060, 1.0, kPeople2},
    {"p3at", 0.465, 1.0, 0.0034, 1.0, kAt},
    {"p3at-sh", 1.0, 1.0, 0.0034, 1.0, kAt},
    {"p3atiw-sh", 1.0, 1.0, 0.0034, 1.0, kAt},
    {"p3dx", 0.485, 1.0, 0.0056, 1.0, kDx},
    {"p3dx-sh", 1.0, 1.0, 0.0056, 1.0, kDx},
    {"patrolbot-sh", 1.0, 1.0, 0.0056, 1.0, kPatrol},
    {"peoplebot-sh", 1.0, 1.0, 0.0060, 1.0, kPeopleSh},
    {"perfpb", 0.485, 1.0, 0.0060, 1.0, kPeople},
    {"perfpb+", 0.485, 1.0, 0.0060, 1.0, kPeople},
    {"powerbot", 0.5813, 1.0, 0.00373, 1.0, kPower},
    {"powerbot-sh", 1.0, 1.0, 0.00373, 1.0, kPower},
    {"powerbot-sh-uarcs", 1.0, 1.0, 0.00373, 1.0, kPowerRear},
    {"researchpb", 1.0, 1.0, 0.0056, 1.0, kPatrol},
};
constexpr const char* kLasers[] = {"-lms1xx", "-lms500", "-tim3xx"};

}  // namespace

std::optional<Model> model_of(const std::string& subtype) {
  std::string name = subtype;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* laser : kLasers) {
    if (name.ends_with(laser)) name = name.substr(0, name.size() - std::strlen(laser));
  }
  const auto* found = std::find_if(std::begin(kEntries), std::end(kEntries),
                                   [&](const Entry& entry) { return name == entry.subtype; });
  if (found == std::end(kEntries)) return std::nullopt;
  Model model{found->distance, found->range, found->difference, found->velocity, {}};
  for (const Row* row : found->rows) {
    if (row == nullptr) continue;
    for (const auto& [x_mm, y_mm, deg] : *row) {
      const bool fitted = x_mm != 0 || y_mm != 0;
      model.robot_from_sonar.push_back(
          fitted ? std::optional(Pose2{x_mm * 1e-3, y_mm * 1e-3, deg_to_rad(deg)}) : std::nullopt);
    }
  }
  return model;
}

}  // namespace marco::drivers::p2os
