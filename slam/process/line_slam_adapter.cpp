#include "slam/process/line_slam_adapter.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

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

// One scan of the filter as a line of JSON: x and P before and after, and per observed wall z, its
// match, nu, S, K's rows of the robot and the distance. In place of the thesis' matrix dump.
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

}  // namespace

LineSlamAdapter::LineSlamAdapter(const LineProcessOptions& options,
                                 process::Bus& bus,
                                 std::function<void(const std::string&)> warn)
    : Mapper2dAdapter(bus, options, channels::kLineMap, std::move(warn)),
      options_(options),
      mapper_(options.mapper) {
  validate(options, "line_process");
  if (!options_.checkpoint_path.empty()) {
    if (const auto checkpoint = load_checkpoint(options_.checkpoint_path)) {
      mapper_.restore(checkpoint->mapper);
      last_scan_ = progress_.newest_scan = checkpoint->utime;
      map_revision_ = checkpoint->map_revision;
      resumed_ = true;
    }
  }
  if (!options_.journal_path.empty()) {
    journal_.open(options_.journal_path, std::ios::app);
    require(journal_.good(), "journal_path: cannot write " + options_.journal_path);
  }
}

MappedScan LineSlamAdapter::map_scan(const SynchronizedScan& scan, bool may_draw) {
  const Utime utime = last_scan_.emplace(scan.motion.utime);
  const ScanVelocity velocity = mapper_.velocity_during(scan.odometry_step, scan.duration_s);
  SlamInput input = slam_input(scan, velocity);
  input.may_draw = may_draw;
  ScanInRobot beams;
  if (scan.level) {
    beams = to_robot_frame(scan.scan, scan.info, scan.robot_from_sensor, input.scan,
                           options_.mapper.lines.lines.range_sigma_m);
    ++scans_used_;
  } else {
    drops_.count("tilted");
  }
  LineSlamJournal journal;
  const LineSlamUpdate update =
      mapper_.process(input, beams, journal_.is_open() ? &journal : nullptr);
  if (journal_.is_open() && update.looked) journal_ << journal_line(utime, journal) << '\n';
  MappedScan mapped;
  mapped.used = used_scan(std::move(input), scan.level && update.matched > 0);
  // Walls just added are matched by definition: the first scan has a pose, too.
  const bool matched = scan.level && (update.matched > 0 || progress_.scan_count == 1);
  mapped.estimate = {utime, update.world_from_robot, update.covariance,
                     matched ? PoseEstimate::Status::matched : PoseEstimate::Status::predicted,
                     update.overlap};
  mapped.trajectory_changed = update.trajectory_changed;
  return mapped;
}

void LineSlamAdapter::publish_map(Utime utime) {
  if (!last_scan_) return;
  LineMap map = mapper_.map();
  for (RoundWall& round : map.round_walls) {
    round.id = -round.id;
    const Walls chords = chords_of(round);
    map.walls.insert(map.walls.end(), chords.begin(), chords.end());
  }
  bus_.publish(channels::kLineMap, to_message(map.walls, utime, ++map_revision_));
}

std::string LineSlamAdapter::mapping_line() const {
  return std::to_string(mapper_.filter().num_walls()) + " walls";
}

LineCheckpoint LineSlamAdapter::checkpoint() {
  return {last_scan_.value_or(Utime{}), map_revision_, mapper_.store()};
}

std::function<void()> LineSlamAdapter::checkpoint_job() {
  return [path = options_.checkpoint_path, now = checkpoint()] { save_checkpoint(path, now); };
}

void LineSlamAdapter::reset(const Pose2& world_from_robot) {
  mapper_ = LineMapper(options_.mapper, world_from_robot);
}

std::string LineSlamAdapter::execute_on_map(const SlamOrder& order) {
  const auto path = order.folder / "line_slam.checkpoint";
  switch (order.command) {
    case slam_command_t::SAVE:
      return orders_.write([path, now = checkpoint()] {
        save_checkpoint(path.string(), now);
        return "SAVE " + path.string() + ": saved";
      });
    case slam_command_t::LOCALIZE:
      throw std::invalid_argument("LOCALIZE: the line SLAM cannot relocalize");
    case slam_command_t::EXTEND:
      throw std::invalid_argument("EXTEND: the line SLAM cannot relocalize");
    case slam_command_t::RESET:
      reset({});
      return "RESET: starting a new map";
    default:  // SET_POSE
      reset(order.world_from_robot);
      return "SET_POSE: starting a new map from there";
  }
}

void LineSlamAdapter::finish() {
  Mapper2dAdapter::finish();
  if (!last_scan_) return;
  if (!options_.checkpoint_path.empty()) save_checkpoint(options_.checkpoint_path, checkpoint());
  if (journal_.is_open()) journal_.flush();
}

}  // namespace marco::slam
