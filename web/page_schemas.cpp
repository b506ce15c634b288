#include "web/page_schemas.hpp"

#include <map>

#include "lcm_tools/base/check.hpp"

namespace marco::web {
namespace {

const std::string kText = R"({"type":"string"})", kNumber = R"({"type":"number"})",
                  kCount = R"({"type":"integer"})", kYesNo = R"({"type":"boolean"})";

std::string list_of(const std::string& items) {
  return R"({"type":"array","items":)" + items + "}";
}

std::string object(std::initializer_list<std::pair<const char*, std::string>> fields) {
  std::string json;
  for (const auto& [name, type] : fields) {
    json += (json.empty() ? "\"" : ",\"") + std::string(name) + "\":" + type;
  }
  return R"({"type":"object","properties":{)" + json + "}}";
}

const std::map<std::string, std::string>& schemas() {
  static const std::map<std::string, std::string> kAll = {
      {"page/tiles",
       object({{"revision", kCount},
               {"resolution_m", kNumber},
               {"clear", kYesNo},
               {"tiles",
                list_of(object({{"x_m", kNumber},
                                {"y_m", kNumber},
                                {"width", kCount},
                                {"height", kCount},
                                {"png", R"({"type":"string","contentEncoding":"base64"})"}}))}})},
      {"page/scan",
       object({{"utime", kCount}, {"x_m", list_of(kNumber)}, {"y_m", list_of(kNumber)}})},
      {"page/health",
       object({{"utime", kCount},
               {"programs",
                list_of(object(
                    {{"name", kText}, {"state", kText}, {"text", kText}, {"age_s", kNumber}}))},
               {"channels", list_of(object({{"name", kText},
                                            {"type", kText},
                                            {"hz", kNumber},
                                            {"lost", kCount},
                                            {"age_s", kNumber}}))},
               {"findings",
                list_of(object({{"severity", kText}, {"text", kText}, {"remedy", kText}}))},
               {"battery_v", list_of(kNumber)},
               {"latency_ms", R"({"type":["number","null"]})"},
               {"clients", kCount},
               {"refused", kCount},
               {"dropped", kCount}})},
      {"page/commands", object({{"deputies", list_of(kText)},
                                {"commands", list_of(object({{"name", kText},
                                                             {"group", kText},
                                                             {"host", kText},
                                                             {"state", kText},
                                                             {"exec", kText}}))}})},
      {"page/output", object({{"command", kText}, {"text", kText}})},
      {"page/goal",
       object({{"active", kYesNo}, {"text", kText}, {"x_m", kNumber}, {"y_m", kNumber}})},
      {"page/stop", object({{"engaged", kYesNo}, {"by", kText}})}};
  return kAll;
}

}  // namespace

std::string page_schema(const std::string& topic) {
  const auto at = schemas().find(topic);
  require(at != schemas().end(), topic + " is not a channel of the page");
  return at->second;
}

uint32_t add_page_channel(Hub& hub, const std::string& topic) {
  std::string name = topic;
  name[topic.find('/')] = '.';
  return hub.add_channel(topic, name, page_schema(topic));
}

}  // namespace marco::web
