#include "web/site.hpp"

#include <gmock/gmock.h>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::web {
namespace {

namespace fs = std::filesystem;

class SiteOfAFolder : public ::testing::Test {
 protected:
  SiteOfAFolder() {
    for (const char* name : {"map/photographs", "elsewhere"}) {
      fs::create_directories(folder_.path() / name);
    }
    folder_.write("secret", "secret");
    folder_.write("map/model.glb", "glTF");
    folder_.write("map/report.json", "{}");
    folder_.write("map/photographs/1.jpg", "jpeg");
    fs::create_symlink(folder_.path() / "secret", folder_.path() / "map/link");
    site_.show_folder(folder_.path() / "map",
                      R"({"model":"files/model.glb","photographs":[{"file":"photographs/1.jpg"},)"
                      R"({"file":"../secret"},{"file":"link"},{"file":"/etc/passwd"},7]})");
  }
  std::string get(const std::string& target) const {
    const Site::Answer answer = site_.get(target);
    if (answer.status != 200) return "";
    return answer.file.empty() ? answer.body : files::read_whole_file(answer.file);
  }

  static std::optional<std::string_view> page(std::string_view name) {
    if (name == "index.html") return "<html>";
    if (name == "page.js") return "export {}";
    return std::nullopt;
  }
  testing::TemporaryFolder folder_;
  Site site_{page, folder_.path() / "missing.js"};
};

TEST_F(SiteOfAFolder, HasThePage) {
  EXPECT_EQ(get("/"), "<html>");
  EXPECT_EQ(get("/?token=x"), "<html>");
  EXPECT_EQ(get("/page/page.js"), "export {}");
  EXPECT_EQ(site_.get("/page/page.js").type, "text/javascript; charset=utf-8");
  EXPECT_EQ(site_.get("/page/three.js").status, 404);
}

TEST_F(SiteOfAFolder, HasWhatTheSnapshotNames) {
  EXPECT_EQ(get("/files/model.glb"), "glTF");
  EXPECT_EQ(get("/files/photographs/1.jpg"), "jpeg");
  EXPECT_EQ(site_.get("/files/model.glb").type, "model/gltf-binary");
  EXPECT_NE(get("/snapshot.json"), "");
}

TEST_F(SiteOfAFolder, LeadsNowhereElse) {
  for (const char* target :
       {"/files/report.json", "/files/../secret", "/files/..%2fsecret", "/files/%2e%2e/secret",
        "/files/link", "/files//etc/passwd", "/files/", "/page/../secret", "/page/%2e%2e%2fsecret",
        "/page/", "/page", "//secret", "/secret", "", "*", "/page/page.js%00.png",
        "/page/..\\secret", "/files/photographs", "/files/photographs/../model.glb"}) {
    EXPECT_EQ(get(target), "") << target;
  }
}

TEST(SiteWithoutAFolder, HasNoSnapshot) {
  const auto no_page = [](std::string_view) { return std::optional<std::string_view>(); };
  EXPECT_EQ(Site(no_page, "/nowhere").get("/snapshot.json").status, 404);
}

TEST(Query, HoldsValues) {
  EXPECT_EQ(query_value("/?a=1&token=x%2By", "token"), "x+y");
  EXPECT_EQ(query_value("/?token", "token"), "");
  EXPECT_EQ(query_value("/", "token"), "");
  EXPECT_EQ(query_value("/?xtoken=1&token=%zz", "token"), "%zz");
}

}  // namespace
}  // namespace marco::web
