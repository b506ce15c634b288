#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/progress.hpp"
#include "plan/known_plan/deviation_sheet.hpp"
#include "plan/known_plan/plan_sight.hpp"
#include "plan/make_plan.hpp"
#include "plan/sheet/plan_export.hpp"
#include "plan/sheet/plan_sheet.hpp"
#include "slam/process/map_folder.hpp"

namespace marco {
namespace {

struct Arguments {
  std::string folder;
  std::string names;
  plan::SheetWish sheet;
  std::string import, against;  ///< drawings
  plan::PlanWish wish;
  std::vector<double> start;  ///< x, y [m], heading [degrees]
};

// One name a line, in the order of the plan's rooms; perhaps with a byte order mark.
void name_rooms(plan::FloorPlan& plan, const std::string& path) {
  const std::string text = files::read_whole_file(path);
  std::size_t begin = text.starts_with("\xEF\xBB\xBF") ? 3 : 0;
  for (plan::PlanRoom& room : plan.rooms) {
    if (begin >= text.size()) return;
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string name = text.substr(begin, end - begin);
    if (!name.empty() && name.back() == '\r') name.pop_back();
    if (!name.empty()) room.name = printable(name);
    begin = end + 1;
  }
  require(begin >= text.size(), path + ": contains more names than the plan has rooms (" +
                                    std::to_string(plan.rooms.size()) + ")");
}

void print_table(const plan::FloorPlan& plan) {
  std::printf("%-16s %9s %9s %13s %7s\n", "room", "area [m2]", "sigma", "size [m]", "seen");
  for (const plan::PlanRoom& room : plan.rooms) {
    std::printf("%-16s %9.2f %9.2f %6.2f x %4.2f %6.0f%%\n", room.name.c_str(), room.area_m2,
                room.area_sigma_m2, room.size_m.x(), room.size_m.y(), 100 * room.seen);
  }
  std::printf("Doors and openings: %zu\n", plan.openings.size());
}

plan::KnownPlan read_plan(const std::string& path, const plan::PlanWish& wish) {
  constexpr std::uintmax_t kLargest = 512U << 20;
  require(std::filesystem::file_size(path) <= kLargest, path + ": is larger than 512 MB");
  try {
    const plan::Drawing drawing = plan::read_drawing(files::read_whole_file(path));
    plan::KnownPlan plan = plan::known_plan_of(drawing, wish);
    const auto list = [](const char* title, const std::vector<std::string>& names) {
      std::string text = title;
      for (const std::string& name : names) text += (name.empty() ? " (none)" : " " + name) + ",";
      if (!names.empty()) std::printf("%s\n", text.substr(0, text.size() - 1).c_str());
    };
    list("layers with walls:", plan.taken);
    list("ignored:", plan.passed_over);
    for (const auto& [kind, count] : drawing.left_out) {
      std::printf("left out: %d x %s\n", count, kind.c_str());
    }
    const Eigen::Vector2d size = plan.high_m() - plan.low_m();
    std::printf("the plan is %.2f x %.2f m\n", size.x(), size.y());
    return plan;
  } catch (const std::invalid_argument& wrong) {
    throw std::invalid_argument(path + ": " + wrong.what());
  }
}

int import_plan(const Arguments& arguments) {
  const plan::PlanSight sight = plan::look_about(read_plan(arguments.import, arguments.wish));
  slam::save_map_folder(arguments.folder, plan::map_of_plan(sight), {});
  std::printf("%s is a map to localize in: ./marco map LOG --localize %s\n",
              arguments.folder.c_str(), arguments.folder.c_str());
  return 0;
}

std::optional<Pose2> place_of(const slam::SavedMap& map,
                              const plan::PlanSight& sight,
                              const std::vector<double>& start) {
  if (start.empty()) return plan::find_in_plan(sight, map.slam.keyframes.keys);
  const Trajectory path = slam::trajectory_of(map.slam.path.scans, map.slam.keyframes.keys);
  require(!path.empty(), "the map has no path, so --start has no meaning");
  return Pose2{start[0], start[1], deg_to_rad(start[2])} * path.front().world_from_robot.inverse();
}

int compare(const Arguments& arguments) {
  const std::filesystem::path folder = arguments.folder;
  const slam::SavedMap map = slam::load_map_folder(folder);
  std::optional<process::Progress> progress;
  progress.emplace("searching the plan for the map").show();
  const plan::KnownPlan plan = read_plan(arguments.against, arguments.wish);
  const plan::PlanSight sight = plan::look_about(plan);
  const std::optional<Pose2> place = place_of(map, sight, arguments.start);
  // Where no place stands out it may lie as the map does: Marco's own plans of it do.
  const plan::PlanDeviations found =
      plan::compare_with_plan(sight.faces, map.slam.keyframes.keys, place.value_or(Pose2{}));
  constexpr double kLeastAgreeing = 0.3, kLeastOfAGuess = 0.7;
  require(place || found.fit.agreeing >= kLeastOfAGuess,
          arguments.folder + ": was not found in " + arguments.against +
              ", or in several places: pass --start X Y DEG, or the right --unit or --layers");
  require(found.fit.agreeing >= kLeastAgreeing,
          "of the map's walls only " + std::to_string(static_cast<int>(100 * found.fit.agreeing)) +
              " % are on walls of the plan: this is another building, or a wrong --start");
  files::write_whole_file(folder / "deviations.json", plan::deviations_json(found, plan));
  files::write_whole_file(folder / "deviations.svg", plan::deviations_svg(found, plan));
  std::fputs(plan::deviation_table(found).c_str(), stdout);
  std::printf("deviations.json and deviations.svg are in %s\n", folder.c_str());
  return 0;
}

int run(const Arguments& arguments) {
  if (!arguments.import.empty()) return import_plan(arguments);
  require(std::filesystem::is_directory(arguments.folder),
          arguments.folder + ": there is no such folder");
  if (!arguments.against.empty()) return compare(arguments);
  const std::filesystem::path folder = arguments.folder;
  const slam::SavedMap map = slam::load_map_folder(folder);
  std::optional<process::Progress> progress;
  progress.emplace("drawing the plan").show();
  plan::FloorPlan plan = plan::make_plan(map.slam.keyframes.keys);
  if (!arguments.names.empty()) name_rooms(plan, arguments.names);
  plan::SheetWish wish = arguments.sheet;
  const std::string name =
      printable(std::filesystem::absolute(folder / ".").parent_path().filename().string());
  wish.title = wish.title.empty() ? "Floor plan: " + name : printable(wish.title);
  wish.source = "Measured by laser; map folder " + name + ", " +
                std::to_string(map.slam.keyframes.keys.size()) + " keyframes.";
  const plan::Sheet sheet = plan::draw_sheet(plan, wish);
  const plan::SheetPdf pdf = plan::sheet_pdf(sheet);
  files::write_whole_file(folder / "plan.pdf", pdf.bytes);
  files::write_whole_file(folder / "plan.svg", plan::sheet_svg(sheet));
  files::write_whole_file(folder / "plan.dxf", plan::plan_dxf(plan));
  files::write_whole_file(folder / "plan.json", plan::plan_json(plan));
  progress.reset();
  print_table(plan);
  if (!pdf.missing.empty()) {
    print(stderr,
          "plan.pdf: no installed font has these letters: %s (Debian's "
          "fonts-noto-core and fonts-noto-cjk have nearly all)\n",
          pdf.missing.c_str());
  }
  std::printf("plan.pdf, plan.svg, plan.dxf and plan.json are in %s\n", folder.c_str());
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco-plan", [&] {
    marco::process::CommandLine app(
        "Makes the floor plan of a map: walls, doors, rooms with areas and dimensions, to scale.\n"
        "Writes plan.pdf, plan.svg, plan.dxf and plan.json into the map folder.\n"
        "With a drawn plan: the building's deviations from it (--against), or a map to localize in "
        "(--import).");
    marco::Arguments arguments;
    app.add_option("OUT", arguments.folder,
                   "a folder that `marco map` wrote; with --import, the one to write")
        .required();
    app.add_option("--scale", arguments.sheet.scale,
                   "100 for 1:100; default: the largest standard scale that fits")
        .between(1, 10000);
    app.add_option("--paper", arguments.sheet.paper,
                   "A4, A3, A2, A1 or A0; default: the smallest that fits");
    app.add_option("--title", arguments.sheet.title, "for the title block");
    app.add_option("--names", arguments.names,
                   "a text file with the rooms' names, one per line: Room 1 first")
        .existing_file();
    auto against = app.add_option(
        "--against", arguments.against,
        "a plan (DXF or SVG): writes deviations.json and deviations.svg with each wall's deviation "
        "from the plan, missing walls and walls that are not drawn");
    against.existing_file();
    app.add_option("--import", arguments.import,
                   "a plan (DXF or SVG): OUT becomes a map for `marco map LOG --localize OUT`")
        .excludes(against)
        .existing_file();
    app.add_option("--layers", arguments.wish.layers,
                   "layers of the plan with walls, separated by commas; default: chosen by their "
                   "names");
    app.add_option(
        "--unit", arguments.wish.unit,
        "unit of the plan: mm, cm, m, in, ft, metres as a number, or 1:100; default: the file's");
    app.add_option("--start", arguments.start,
                   "pose in the plan where the drive began: x and y in metres, heading in degrees; "
                   "without it the whole plan is searched")
        .values(3)
        .needs(against);
    if (const auto code = app.parse(argc, argv)) return *code;
    return marco::run(arguments);
  });
}
