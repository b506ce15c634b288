#include "drivers/rplidar/model.hpp"

#include <map>

namespace marco::drivers::rplidar {

std::string model_name(int model) {
  static const std::map<int, const char*> kFamilies{{1, "A1"}, {2, "A2"}, {3, "A3"}, {4, "C1"},
                                                    {6, "S1"}, {7, "S2"}, {8, "S3"}};
  const auto family = kFamilies.find(family_of(model));
  return family == kFamilies.end() ? "RPLIDAR, model " + std::to_string(model)
                                   : std::string("RPLIDAR ") + family->second;
}

}  // namespace marco::drivers::rplidar
