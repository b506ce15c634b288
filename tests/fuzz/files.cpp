// Files that somebody sent: each input becomes a file in memory, which the readers open by path.
#include <sys/mman.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/files/glb.hpp"
#include "common/files/map_yaml.hpp"
#include "common/files/obj.hpp"
#include "common/files/ply.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/log/repair.hpp"
#include "plan/drawing/drawing.hpp"
#include "recordings/recording.hpp"
#include "recordings/tilted_scans.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

namespace fs = std::filesystem;

/// Reads all there is; a reader's complaint is an answer, too.
template <class Read>
void quietly(Read read) {
  try {
    read();
  } catch (const std::invalid_argument&) {
  } catch (const std::runtime_error&) {
  }
}

void read_all(files::SampleReader& reader, std::size_t bytes) {
  std::size_t samples = 0;
  while (reader.next()) ++samples;
  // A line or a row of two characters may be a sample, an event of 28 bytes can give two. Chunks
  // may be compressed, at most by the thousand.
  const bool is_packed = reader.report().format.find("LCM") == std::string::npos &&
                         reader.report().format.find("log") == std::string::npos;
  promise(samples <= (is_packed ? 5000 : 4) * bytes + 16, "no more samples than bytes");
  promise(reader.progress() >= 0.0 && reader.progress() <= 1.0, "progress lies in 0..1");
  reader.report();
}

MARCO_FUZZ(event_log) {
  const MemoryFile file(bytes);
  files::EventLogReader reader(file.path());
  int64_t used = 0;
  while (const auto event = reader.next()) {
    used += 28 + static_cast<int64_t>(event->channel.size() + event->bytes.size());
  }
  promise(used + reader.damage().bytes_skipped == static_cast<int64_t>(bytes.size()),
          "each byte is part of an event or of the damage");
  reader.seek(static_cast<int64_t>(bytes.size() / 2));
  while (const auto head = reader.next_head()) reader.data();
}

MARCO_FUZZ(recording) {
  const MemoryFile file(bytes);
  quietly([&] { read_all(*open_recording(file.path()), bytes.size()); });
}

/// A folder with a scan and its pose.
MARCO_FUZZ(tilted_scans) {
  Input input(bytes);
  const uint8_t kind = input.byte();
  static const TemporaryFolder kFolder;
  constexpr const char* kNames[] = {"scan000_tilt_ranges_mm.csv", "scan000.3d", "scan_polar.csv"};
  const fs::path scan = kFolder.path() / kNames[kind % 3];
  const fs::path pose = kFolder.path() / "scan000.pose";
  write_file(pose, input.take(input.byte()));
  write_file(scan, input.rest());
  quietly([&] { read_all(*files::open_tilted_scans({kFolder.path()}), 400 * bytes.size()); });
  fs::remove(scan);
  fs::remove(pose);
}

MARCO_FUZZ(result_files) {
  Input input(bytes);
  const uint8_t kind = input.byte();
  const auto rest = input.rest();
  const MemoryFile file(rest);
  if (kind % 2 == 0) quietly([&] { files::read_tum(file.path()); });
  if (kind % 2 == 1) quietly([&] { files::read_ply(file.path()); });
}

MARCO_FUZZ(glb) {
  const MemoryFile file(bytes);
  quietly([&] {
    const TexturedMesh read = files::read_glb(file.path());
    for (const auto& triangle : read.mesh.triangles) {
      for (const uint32_t corner : triangle) {
        promise(corner < read.mesh.vertices_m.size(), "a triangle's vertices are there");
      }
    }
  });
}

MARCO_FUZZ(obj) {
  const MemoryFile file(bytes);
  quietly([&] {
    const TriangleMesh read = files::read_obj(file.path());
    for (const auto& triangle : read.triangles) {
      for (const uint32_t corner : triangle) {
        promise(corner < read.vertices_m.size(), "a triangle's vertices are there");
      }
    }
  });
}

MARCO_FUZZ(drawing) {
  quietly([&] {
    const plan::Drawing drawing = plan::read_drawing(std::string(bytes.begin(), bytes.end()));
    for (const plan::DrawnLine& line : drawing.lines) {
      promise(line.from.allFinite() && line.to.allFinite(), "lines are finite");
      promise(line.layer >= 0 && static_cast<std::size_t>(line.layer) < drawing.layers.size(),
              "a line's layer is there");
    }
  });
}

MARCO_FUZZ(map_yaml) {
  Input input(bytes);
  static const TemporaryFolder kFolder;
  write_file(kFolder.path() / "map.yaml", input.piece());
  write_file(kFolder.path() / "map.pgm", input.rest());
  quietly([&] { files::read_map(kFolder.path() / "map.yaml"); });
}

MARCO_FUZZ(log_repair) {
  const MemoryFile file(bytes);
  static const TemporaryFolder kFolder;
  quietly([&] {
    logs::OutputFile out(kFolder.path() / "out.lcm", logs::Existing::replace, {});
    const logs::RepairReport report = logs::repair_log(
        file.path(), out, logs::Mending::headers,
        [](std::span<const uint8_t> message) { return message.size() % 2 == 0; }, [](double) {});
    out.finish();
    logs::to_text(report);
    logs::to_json(report);
    files::EventLogReader reader(kFolder.path() / "out.lcm");
    int64_t events = 0;
    while (reader.next_head()) ++events;
    promise(events == report.events, "a repaired log has the events it says");
    promise(reader.damage().places == 0, "a repaired log is whole");
  });
}

}  // namespace
}  // namespace marco::fuzz
