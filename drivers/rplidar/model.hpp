#pragma once

#include <string>

namespace marco::drivers::rplidar {

/// "RPLIDAR A2"; "RPLIDAR, model 77" when it is not known. @param model  first byte of its INFO.
std::string model_name(int model);
/// The generation: 1 to 3 an A, 4 C1, 6 to 8 an S.
inline int family_of(int model) { return model >> 4; }

}  // namespace marco::drivers::rplidar
