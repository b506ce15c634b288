#include "tools/map/verdict.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "slam/map/visits.hpp"
#include "slam/process/mapper2d_adapter.hpp"

namespace marco {
namespace {

using nlohmann::json;

constexpr viewer::Rgb kContradictionRed{214, 39, 40};
constexpr double kPictureRobotM = 0.15;

struct JsonVisitor {
  json& object;
  template <class Value>
  void operator()(const char* name, const Value& value) {
    object[name] = value;
  }
};

std::string picture_name(std::size_t reason) {
  return "doctor_" + std::to_string(reason + 1) + ".png";
}

// Since the first scan of the recordings.
double seconds_into(const MapJob& job, Utime utime) {
  Utime first = utime;
  for (const StampedPose2& pose : job.adapter().live_trajectory())
    first = std::min(first, pose.utime);
  return (utime - first).seconds();
}

json reason_json(const slam::Reason& reason, const MapJob& job) {
  json remedies = json::array();
  for (const slam::MapEdit& edit : reason.remedies) remedies.push_back(to_line(edit));
  return {{"verdict", to_string(reason.verdict)},
          {"cause", to_string(reason.cause)},
          {"x_m", reason.place_m.x()},
          {"y_m", reason.place_m.y()},
          {"from_utime", reason.from.us},
          {"to_utime", reason.to.us},
          {"from_s", seconds_into(job, reason.from)},
          {"to_s", seconds_into(job, reason.to)},
          {"why", reason.why},
          {"edits", remedies}};
}

void add_points(const Points2& points,
                const viewer::Rgb& color,
                const char* label,
                viewer::Scene& scene) {
  if (points.cols() == 0) return;
  viewer::PointsItem& item = scene.points.emplace_back(viewer::PointsItem{{}, color, label});
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector2f point = points.col(i).cast<float>();
    item.points_m.emplace_back(point.x(), point.y(), 0.0F);
  }
}

Points2 points_of(const std::vector<slam::Keyframe>& keys, const std::vector<int>& chosen) {
  Eigen::Index count = 0;
  for (const int key : chosen) {
    count += keys[static_cast<std::size_t>(key)].points_in_robot.points.cols();
  }
  Points2 points(2, count);
  Eigen::Index next = 0;
  for (const int key : chosen) {
    const slam::Keyframe& one = keys[static_cast<std::size_t>(key)];
    points.middleCols(next, one.points_in_robot.points.cols()) =
        one.world_from_robot * one.points_in_robot.points;
    next += one.points_in_robot.points.cols();
  }
  return points;
}

}  // namespace

std::optional<MapVerdict> judge_map(const MapJob& job) {
  auto evidence = job.evidence();
  if (!evidence) return std::nullopt;
  MapVerdict verdict{std::move(*evidence), {}};
  verdict.diagnosis = slam::examine(verdict.evidence);
  if (const slam::MapEdits mended = job.mended(); !mended.empty()) {
    // A break is repaired only where both sides were seen again: the part between may still be off.
    char text[200];
    std::snprintf(text, sizeof text,
                  "the map contradicted itself and was repaired by adding or removing %zu loop "
                  "closures, the first between %.1f and %.1f s: check these places",
                  mended.size(), seconds_into(job, mended.front().from),
                  seconds_into(job, mended.front().to));
    verdict.diagnosis.ask(text);
  }
  return verdict;
}

void add_verdict(json& report, const MapVerdict& verdict, const MapJob& job) {
  slam::DoctorFigures figures = verdict.diagnosis.figures;
  json figures_json, reasons = json::array();
  JsonVisitor visitor{figures_json};
  figures.visit(visitor);
  for (const slam::Reason& reason : verdict.diagnosis.reasons) {
    reasons.push_back(reason_json(reason, job));
    if (reason.has_place()) reasons.back()["picture"] = picture_name(reasons.size() - 1);
  }
  report["verdict"] = to_string(verdict.diagnosis.verdict);
  json mended = json::array();
  for (const slam::MapEdit& edit : job.mended()) mended.push_back(to_line(edit));
  report["doctor"] = {{"figures", figures_json},
                      {"reasons", reasons},
                      {"mended", mended},
                      {"open_questions", verdict.diagnosis.open_questions}};
}

void mark_map(const std::filesystem::path& folder, const MapVerdict& verdict) {
  const std::filesystem::path yaml = folder / "map.yaml";
  if (!verdict.is_wrong() || !std::filesystem::exists(yaml)) return;
  files::write_whole_file(yaml,
                          "# verdict: wrong. Places and reasons: report.json and doctor_*.png\n" +
                              files::read_whole_file(yaml));
}

void mark_picture(PictureOrder& map_picture, const MapVerdict& verdict) {
  if (verdict.diagnosis.verdict == slam::Verdict::good) return;
  const std::string label = std::string("verdict: ") + to_string(verdict.diagnosis.verdict);
  constexpr double kCircleM = 1.0;
  for (const slam::Reason& reason : verdict.diagnosis.reasons) {
    if (!reason.has_place()) continue;
    map_picture.scene.ellipses.push_back(
        {reason.place_m, kCircleM * Eigen::Matrix2d::Identity(), 1.0, kContradictionRed});
  }
  map_picture.scene.paths.push_back({{}, kContradictionRed, label});
}

std::vector<PictureOrder> doctor_pictures(const std::filesystem::path& folder,
                                          const MapVerdict& verdict) {
  std::vector<PictureOrder> orders;
  const std::vector<slam::Keyframe>& keys = verdict.evidence.keys;
  for (std::size_t i = 0; i < verdict.diagnosis.reasons.size(); ++i) {
    const slam::Reason& reason = verdict.diagnosis.reasons[i];
    if (!reason.has_place()) continue;
    PictureOrder order{folder / picture_name(i), true, "", {}};
    add_points(points_of(keys, reason.older_keys), viewer::palette::kTruth, "seen before",
               order.scene);
    add_points(points_of(keys, reason.newer_keys), viewer::palette::kOdometry, "seen here",
               order.scene);
    add_points(points_in_free_space(keys, reason.older_keys, reason.newer_keys), kContradictionRed,
               "was free before", order.scene);
    add_points(points_in_free_space(keys, reason.newer_keys, reason.older_keys), kContradictionRed,
               "", order.scene);
    for (const int key : reason.newer_keys) {
      order.scene.robots.push_back({keys[static_cast<std::size_t>(key)].world_from_robot,
                                    kPictureRobotM, kPictureRobotM, viewer::palette::kOdometry});
    }
    orders.push_back(std::move(order));
  }
  return orders;
}

void print_verdict(const MapVerdict& verdict, const MapJob& job, bool with_pictures) {
  const std::vector<slam::Reason>& reasons = verdict.diagnosis.reasons;
  bool told = false;
  for (std::size_t i = 0; i < reasons.size(); ++i) {
    const slam::Reason& reason = reasons[i];
    print(stdout, "%s", to_string(reason.verdict));
    if (reason.has_place()) {
      print(stdout, " at (%.1f, %.1f) m,", reason.place_m.x(), reason.place_m.y());
    }
    print(stdout, " %.1f to %.1f s: %s\n", seconds_into(job, reason.from),
          seconds_into(job, reason.to), reason.why.c_str());
    if (with_pictures && reason.has_place()) {
      print(stdout, "  picture: %s\n", picture_name(i).c_str());
    }
    if (reason.remedies.empty()) continue;
    print(stdout, "  %s%s\n", to_line(reason.remedies.front()).c_str(),
          told ? "" : "   (suggested fix: put it in a file for --edits)");
    told = true;
    for (std::size_t other = 1; other < reason.remedies.size(); ++other) {
      print(stdout, "  or: %s\n", to_line(reason.remedies[other]).c_str());
    }
  }
  for (const std::string& question : verdict.diagnosis.open_questions) {
    print(stdout, "doubtful: %s\n", question.c_str());
  }
  const char* const said = to_string(verdict.diagnosis.verdict);
  if (isatty(STDOUT_FILENO) == 0 || std::getenv("NO_COLOR") != nullptr) {
    print(stdout, "verdict: %s\n", said);
    return;
  }
  constexpr int kGreen = 32, kYellow = 33, kRed = 31;
  const int colour = verdict.is_wrong()                                     ? kRed
                     : verdict.diagnosis.verdict == slam::Verdict::doubtful ? kYellow
                                                                            : kGreen;
  std::printf("verdict: \033[1;%dm%s\033[0m\n", colour, said);
}

}  // namespace marco
