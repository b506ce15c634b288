#include "web/snapshot/bundle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "web/page/page_files.hpp"

namespace marco::web {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

std::string bundle(const std::map<std::string, std::string, std::less<>>& modules) {
  return bundle_modules("app.js", [&](std::string_view name) -> std::optional<std::string_view> {
    const auto found = modules.find(name);
    if (found == modules.end()) return std::nullopt;
    return found->second;
  });
}

TEST(Bundle, RunsAModuleBehindThoseItImportsAndOnce) {
  const std::string script = bundle(
      {{"app.js", "import { a } from \"./a.js\";\nimport { b } from \"./b.js\";\nstart(a, b);\n"},
       {"b.js", "import { a } from \"./a.js\";\nexport function b() {\n  return a;\n}\n"},
       {"a.js", "const hidden = 1;\nexport const a = hidden;\n"}});
  const std::size_t a = script.find("const hidden"), b = script.find("function b()");
  EXPECT_LT(a, b);
  EXPECT_LT(b, script.find("start(a, b);"));
  EXPECT_EQ(script.find("const hidden", a + 1), std::string::npos);
  EXPECT_THAT(script, HasSubstr("const { a } = modules[\"a.js\"];"));
  EXPECT_THAT(script, HasSubstr("return {b, };"));
  EXPECT_THAT(script, testing::Not(HasSubstr("export ")));
}

TEST(Bundle, RefusesWhatItWouldBreak) {
  EXPECT_THAT(
      [] {
        bundle({{"app.js", "import { a } from \"./gone.js\";\n"}});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("gone.js: no such module")));
  EXPECT_THAT(
      [] {
        bundle({{"app.js", "import a from \"./a.js\";\n"}, {"a.js", ""}});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("cannot be bundled")));
  EXPECT_THAT(
      [] {
        bundle({{"app.js", "export let a = 1;\n"}});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("cannot be bundled")));
  EXPECT_THAT(
      [] {
        bundle({{"app.js", "import { b } from \"./b.js\";\n"},
                {"b.js", "import { a } from \"./app.js\";\n"}});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("in a cycle")));
}

TEST(Bundle, TheWholePageIsInIt) {
  const std::string script = bundle_modules("app.js", page_file);
  for (const char* name : {"app.js", "map_view.js", "socket.js", "space.js", "glb.js"}) {
    EXPECT_THAT(script, HasSubstr("modules[\"" + std::string(name) + "\"] = "));
  }
}

}  // namespace
}  // namespace marco::web
