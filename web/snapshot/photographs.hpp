#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace marco::web {

/// The pictures that `folder`/photographs.toml lists and that lie in the folder: [{"file", "x_m",
/// "y_m", "z_m", "theta_rad"}], where each camera stood and looked. An empty list without that
/// file.
/// @throws std::invalid_argument naming the file and what is wrong with it.
nlohmann::json photographs_json(const std::filesystem::path& folder);

}  // namespace marco::web
