#pragma once

#include <filesystem>
#include <string>

namespace marco::web {

/// A map folder as JSON, for the page: {"name", "resolution_m", "tiles" (web/tiles.hpp), "path",
/// "live_path", "odometry" and "truth" ([t_s, x_m, y_m, theta_rad] each, thinned to what can be
/// seen; t_s since the first pose of the path), "loops" ([x0, y0, x1, y1, "taken" or "refused"]),
/// "walls" ([x0, y0, x1, y1]), "verdict" {"word", "reasons" [{"text", "remedy", "x_m", "y_m"}]},
/// "report" (figures by name), "model" ("files/NAME" or null), "photographs" [{"file", "x_m",
/// "y_m", "z_m", "theta_rad"}]}. Metres, in the map's frame: odometry and truth are laid on the
/// path. What the folder does not hold is empty or null; only map.yaml must be there.
/// @throws std::invalid_argument naming what is missing, or which file cannot be read and why.
std::string snapshot_json(const std::filesystem::path& folder);

}  // namespace marco::web
