#include <cstdio>
#include <filesystem>
#include <string>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "slam/plan/make_plan.hpp"
#include "slam/plan/sheet/plan_dxf.hpp"
#include "slam/plan/sheet/plan_json.hpp"
#include "slam/plan/sheet/plan_sheet.hpp"
#include "slam/process/map_folder.hpp"

namespace marco {
namespace {

struct Arguments {
  std::string folder;
  std::string names;
  slam::SheetWish sheet;
};

// One name a line, in the order of the plan's rooms.
void name_rooms(slam::FloorPlan& plan, const std::string& path) {
  const std::string text = files::read_whole_file(path);
  std::size_t begin = 0;
  for (slam::PlanRoom& room : plan.rooms) {
    if (begin >= text.size()) return;
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string name = text.substr(begin, end - begin);
    if (!name.empty() && name.back() == '\r') name.pop_back();
    if (!name.empty()) room.name = name;
    begin = end + 1;
  }
  require(begin >= text.size(), path + ": holds more names than the plan has rooms (" +
                                    std::to_string(plan.rooms.size()) + ")");
}

void print_table(const slam::FloorPlan& plan) {
  std::printf("%-16s %9s %9s %13s %7s\n", "room", "area [m2]", "sigma", "size [m]", "seen");
  for (const slam::PlanRoom& room : plan.rooms) {
    std::printf("%-16s %9.2f %9.2f %6.2f x %4.2f %6.0f%%\n", room.name.c_str(), room.area_m2,
                room.area_sigma_m2, room.size_m.x(), room.size_m.y(), 100 * room.seen);
  }
  std::printf("%zu doors and openings\n", plan.openings.size());
}

int run(const Arguments& arguments) {
  const std::filesystem::path folder = arguments.folder;
  const slam::SavedMap map = slam::load_map_folder(folder);
  slam::FloorPlan plan = slam::make_plan(map.slam.keyframes.keys);
  if (!arguments.names.empty()) name_rooms(plan, arguments.names);
  slam::SheetWish wish = arguments.sheet;
  const std::string name = std::filesystem::absolute(folder / ".").parent_path().filename();
  if (wish.title.empty()) wish.title = "Floor plan: " + name;
  wish.source = "Measured by laser; map folder " + name + ", " +
                std::to_string(map.slam.keyframes.keys.size()) + " keyframes.";
  const slam::Sheet sheet = slam::draw_sheet(plan, wish);
  files::write_whole_file(folder / "plan.pdf", slam::sheet_pdf(sheet));
  files::write_whole_file(folder / "plan.svg", slam::sheet_svg(sheet));
  files::write_whole_file(folder / "plan.dxf", slam::plan_dxf(plan));
  files::write_whole_file(folder / "plan.json", slam::plan_json(plan));
  print_table(plan);
  std::printf("plan.pdf, plan.svg, plan.dxf and plan.json are in %s\n", folder.c_str());
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco-plan", [&] {
    CLI::App app(
        "Makes the floor plan of a map: walls, doors, rooms with areas and dimensions, to scale.\n"
        "Writes plan.pdf, plan.svg, plan.dxf and plan.json into the map folder.");
    marco::Arguments arguments;
    app.add_option("OUT", arguments.folder, "a folder that `marco map` wrote")
        ->required()
        ->check(CLI::ExistingDirectory);
    app.add_option("--scale", arguments.sheet.scale,
                   "100 for 1:100; without it the largest usual one that fits")
        ->check(CLI::Range(1, 10000));
    app.add_option("--paper", arguments.sheet.paper,
                   "A4, A3, A2, A1 or A0; without it the smallest that fits");
    app.add_option("--title", arguments.sheet.title, "for the title block");
    app.add_option("--names", arguments.names,
                   "a text file with the rooms' names, one a line: Room 1 first")
        ->check(CLI::ExistingFile);
    if (const auto code = marco::process::parse_arguments(app, argc, argv)) return *code;
    return marco::run(arguments);
  });
}
