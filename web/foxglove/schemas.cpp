#include "web/foxglove/schemas.hpp"

// Field names and meanings as Foxglove publishes them, in their shortest form.
namespace marco::foxglove {
namespace {

const std::string kTimestamp =
    R"("timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer","minimum":0},)"
    R"("nsec":{"type":"integer","minimum":0,"maximum":999999999}}})";
const std::string kFrame = R"("frame_id":{"type":"string"})";
const std::string kBytes = R"({"type":"string","contentEncoding":"base64"})";

std::string numbers(const std::string& title, const std::string& names) {
  std::string json = R"({"type":"object","title":")" + title + R"(","properties":{)";
  for (std::size_t i = 0; i < names.size(); ++i) {
    json += (i > 0 ? ",\"" : "\"") + std::string(1, names[i]) + R"(":{"type":"number"})";
  }
  return json + "}}";
}

std::string pose() {
  return R"({"type":"object","title":"foxglove.Pose","properties":{"position":)" +
         numbers("foxglove.Vector3", "xyz") + R"(,"orientation":)" +
         numbers("foxglove.Quaternion", "xyzw") + "}}";
}

std::string object(const std::string& title, const std::string& properties) {
  return R"({"title":")" + title + R"(","type":"object","properties":{)" + properties + "}}";
}

std::string array_of(const std::string& items) {
  return R"({"type":"array","items":)" + items + "}";
}

std::string transform() {
  const std::string text = R"({"type":"string"})";
  return kTimestamp + R"(,"parent_frame_id":)" + text + R"(,"child_frame_id":)" + text +
         R"(,"translation":)" + numbers("foxglove.Vector3", "xyz") + R"(,"rotation":)" +
         numbers("foxglove.Quaternion", "xyzw");
}

// Its entities are made of triangles and lines here; other primitives are named, as their lists are
// written.
std::string scene_update() {
  const std::string text = R"({"type":"string"})";
  const std::string lines = object(
      "foxglove.LinePrimitive",
      R"("type":{"type":"integer"},"pose":)" + pose() +
          R"(,"thickness":{"type":"number"},"scale_invariant":{"type":"boolean"},"points":)" +
          array_of(numbers("foxglove.Point3", "xyz")) + R"(,"color":)" +
          numbers("foxglove.Color", "rgba") + R"(,"colors":)" +
          array_of(numbers("foxglove.Color", "rgba")) + R"(,"indices":)" +
          array_of(R"({"type":"integer","minimum":0})"));
  const std::string triangles =
      object("foxglove.TriangleListPrimitive",
             R"("pose":)" + pose() + R"(,"points":)" + array_of(numbers("foxglove.Point3", "xyz")) +
                 R"(,"color":)" + numbers("foxglove.Color", "rgba") + R"(,"colors":)" +
                 array_of(numbers("foxglove.Color", "rgba")) + R"(,"indices":)" +
                 array_of(R"({"type":"integer","minimum":0})"));
  std::string entity = kTimestamp + "," + kFrame + R"(,"id":)" + text +
                       R"(,"lifetime":{"type":"object","title":"duration","properties":)"
                       R"({"sec":{"type":"integer"},"nsec":{"type":"integer"}}})"
                       R"(,"frame_locked":{"type":"boolean"},"metadata":)" +
                       array_of(R"({"type":"object"})");
  for (const char* name : {"arrows", "cubes", "spheres", "cylinders", "texts", "models"}) {
    entity += R"(,")" + std::string(name) + R"(":)" + array_of(R"({"type":"object"})");
  }
  entity += R"(,"lines":)" + array_of(lines) + R"(,"triangles":)" + array_of(triangles);
  return R"("deletions":)" +
         array_of(object("foxglove.SceneEntityDeletion",
                         kTimestamp + R"(,"type":{"type":"integer"},"id":)" + text)) +
         R"(,"entities":)" + array_of(object("foxglove.SceneEntity", entity));
}

}  // namespace

std::string schema_of(const std::string& name) {
  const std::string integer = R"({"type":"integer","minimum":0})";
  const std::string number_list = R"({"type":"array","items":{"type":"number"}})";
  const std::string text = R"({"type":"string"})";
  std::string fields = kTimestamp + "," + kFrame;
  if (name == "foxglove.LaserScan") {
    fields += R"(,"pose":)" + pose() +
              R"(,"start_angle":{"type":"number"},"end_angle":{"type":"number"},"ranges":)" +
              number_list + R"(,"intensities":)" + number_list;
  } else if (name == "foxglove.Grid") {
    fields += R"(,"pose":)" + pose() + R"(,"column_count":)" + integer + R"(,"cell_size":)" +
              numbers("foxglove.Vector2", "xy") + R"(,"row_stride":)" + integer +
              R"(,"cell_stride":)" + integer +
              R"(,"fields":{"type":"array","items":{"type":"object",)"
              R"("title":"foxglove.PackedElementField","properties":{"name":)" +
              text + R"(,"offset":)" + integer + R"(,"type":)" + integer + R"(}}},"data":)" +
              kBytes;
  } else if (name == "foxglove.PosesInFrame") {
    fields += R"(,"poses":{"type":"array","items":)" + pose() + "}";
  } else if (name == "foxglove.PoseInFrame") {
    fields += R"(,"pose":)" + pose();
  } else if (name == "foxglove.FrameTransform") {
    fields = transform();
  } else if (name == "foxglove.FrameTransforms") {
    fields = R"("transforms":)" + array_of(object("foxglove.FrameTransform", transform()));
  } else if (name == "foxglove.Log") {
    fields = kTimestamp + R"(,"level":)" + integer + R"(,"message":)" + text + R"(,"name":)" +
             text + R"(,"file":)" + text + R"(,"line":)" + integer;
  } else if (name == "foxglove.CompressedImage") {
    fields += R"(,"data":)" + kBytes + R"(,"format":)" + text;
  } else if (name == "foxglove.SceneUpdate") {
    fields = scene_update();
  } else if (name == "foxglove.RawImage") {
    fields += R"(,"width":)" + integer + R"(,"height":)" + integer + R"(,"encoding":)" + text +
              R"(,"step":)" + integer + R"(,"data":)" + kBytes;
  }
  return object(name, fields);
}

}  // namespace marco::foxglove
