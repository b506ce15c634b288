#include "slam/process/line_journal.hpp"

#include <nlohmann/json.hpp>

namespace marco::slam {
namespace {

template <class Matrix>
nlohmann::json rows_of(const Matrix& matrix) {
  nlohmann::json rows = nlohmann::json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    nlohmann::json row = nlohmann::json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

nlohmann::json list_of(const Eigen::VectorXd& vector) {
  return {std::vector<double>(vector.data(), vector.data() + vector.size())};
}

const char* result_of(const WallMatch& match) {
  if (match.wall >= 0) return "matched";
  return match.wall == WallMatch::kNew ? "new" : "unclear";
}

}  // namespace

std::string journal_line(Utime utime, const LineSlamJournal& journal) {
  nlohmann::json line;
  line["utime"] = utime.us;
  line["x_predicted"] = list_of(journal.robot_predicted)[0];
  line["P_predicted"] = rows_of(journal.covariance_predicted);
  line["x"] = list_of(journal.robot_corrected)[0];
  line["P"] = rows_of(journal.covariance_corrected);
  line["walls"] = nlohmann::json::array();
  for (std::size_t i = 0; i < journal.observed.size(); ++i) {
    const ObservedWall& wall = journal.observed[i];
    nlohmann::json entry;
    entry["z_m"] = {wall.start_m.x(), wall.start_m.y(), wall.end_m.x(), wall.end_m.y()};
    entry["points"] = wall.num_points;
    entry["ends_seen"] = {wall.start_seen, wall.end_seen};
    entry["result"] = result_of(journal.matches[i]);
    if (journal.matches[i].wall >= 0) {
      entry["id"] = journal.wall_ids[i];
      entry["distance2"] = journal.matches[i].distance2;
      entry["nu_m"] = list_of(journal.innovations[i])[0];
      entry["S"] = rows_of(journal.innovation_covariances[i]);
      entry["K_robot"] = rows_of(journal.robot_gains[i]);
    }
    line["walls"].push_back(std::move(entry));
  }
  return line.dump();
}

}  // namespace marco::slam
