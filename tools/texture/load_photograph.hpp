#pragma once

#include <filesystem>

#include "mapping3d/surface/photograph_list.hpp"

namespace marco {

/// Reads a listed picture. @param folder  that relative file names start from
/// @throws std::invalid_argument, std::runtime_error naming the file and what is wrong with it
mapping3d::CameraPicture load(const PhotographSpec& spec, const std::filesystem::path& folder);

}  // namespace marco
