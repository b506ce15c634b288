#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poppler-document.h>
#include <poppler-page-renderer.h>
#include <poppler-page.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <numbers>

#include "plan/sheet/sheet.hpp"

namespace marco::plan {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kDotsPerInch = 508;  // 0.05 mm
constexpr double kDotsPerMm = kDotsPerInch / 25.4, kPointsPerMm = 72 / 25.4;
constexpr Sheet::Style kThick{0.5, 0, -1, {}};

// A page as another program reads it, on paper: millimetres from the lower left corner.
class ReadPage {
 public:
  explicit ReadPage(const SheetPdf& pdf)
      : bytes_(pdf.bytes),
        document_(
            poppler::document::load_from_raw_data(bytes_.data(), static_cast<int>(bytes_.size()))),
        page_(document_->create_page(0)) {
    renderer_.set_render_hint(poppler::page_renderer::antialiasing);
  }

  std::string title() const { return plain(document_->get_title()); }
  double width_mm() const { return page_->page_rect().width() / kPointsPerMm; }
  double height_mm() const { return page_->page_rect().height() / kPointsPerMm; }

  struct Box {
    double left, right, low, high;
  };
  std::map<std::string, Box> words() const {
    std::map<std::string, Box> found;
    for (const poppler::text_box& word : page_->text_list()) {
      const poppler::rectf box = word.bbox();
      found[plain(word.text())] = {box.left() / kPointsPerMm, box.right() / kPointsPerMm,
                                   height_mm() - box.bottom() / kPointsPerMm,
                                   height_mm() - box.top() / kPointsPerMm};
    }
    return found;
  }

  // Whether there is ink.
  bool is_dark(double x, double y) const { return !dark_runs(x - 0.05, x + 0.05, y).empty(); }

  // Middles of what is dark on the way to the right.
  std::vector<double> dark_runs(double from, double to, double y) const {
    const int left = static_cast<int>(std::lround(from * kDotsPerMm));
    const int width = static_cast<int>(std::lround((to - from) * kDotsPerMm));
    const auto row = static_cast<int>((height_mm() - y) * kDotsPerMm);
    poppler::image image =
        renderer_.render_page(page_.get(), kDotsPerInch, kDotsPerInch, left, row, width, 1);
    std::vector<double> middles;
    int begin = -1;
    for (int i = 0; i <= width; ++i) {
      const bool dark = i < width && static_cast<unsigned char>(image.data()[4 * i]) < 128;
      if (dark && begin < 0) begin = i;
      if (!dark && begin >= 0) {
        middles.push_back((left + (begin + i) / 2.0) / kDotsPerMm);
        begin = -1;
      }
    }
    return middles;
  }

 private:
  static std::string plain(const poppler::ustring& text) {
    const poppler::byte_array bytes = text.to_utf8();
    return {bytes.begin(), bytes.end()};
  }

  std::string bytes_;
  std::unique_ptr<poppler::document> document_;
  std::unique_ptr<poppler::page> page_;
  poppler::page_renderer renderer_;
};

Sheet with_text(const std::string& text) {
  Sheet sheet;
  sheet.texts.push_back({{100, 200}, text, 4.0});
  return sheet;
}

// The first test with letters: fonts are looked for once.
TEST(SheetPdfDeathTest, IsWrittenWithoutAnyFont) {
  const auto writes = [] {
    const std::string none = ::testing::TempDir() + "no_fonts.conf";
    std::ofstream(none) << "<fontconfig></fontconfig>";
    setenv("FONTCONFIG_FILE", none.c_str(), 1);
    Sheet sheet = with_text("Hall");
    sheet.line({20, 50}, {20, 90}, kThick);
    const SheetPdf pdf = sheet_pdf(sheet);
    const ReadPage page(pdf);
    const bool is_blank = page.dark_runs(0, 210, 201).empty();
    std::exit(pdf.missing == "Hal" && page.is_dark(20, 70) && is_blank ? 0 : 1);
  };
  EXPECT_EXIT(writes(), ::testing::ExitedWithCode(0), "");
}

TEST(SheetPdf, IsToScale) {
  Sheet sheet;
  sheet.title = "Łazienka";
  for (const double x : {20.0, 70.0, 190.0}) sheet.line({x, 50}, {x, 90}, kThick);
  const ReadPage page(sheet_pdf(sheet));
  EXPECT_EQ(page.title(), "Łazienka");
  EXPECT_NEAR(page.width_mm(), 210, 0.01);
  EXPECT_NEAR(page.height_mm(), 297, 0.01);
  const std::vector<double> lines = page.dark_runs(0, 210, 70);
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_NEAR(lines[0], 20, 0.05);
  EXPECT_NEAR(lines[1] - lines[0], 50, 0.05);
  EXPECT_NEAR(lines[2] - lines[0], 170, 0.05);
  EXPECT_TRUE(page.is_dark(20, 49.85));  // round, by half a width
  EXPECT_FALSE(page.is_dark(20, 49.65));
}

// A lower half and, on the way back, an upper one; closed, filled and dashed as its style says.
TEST(SheetPdf, DrawsArcsAndFills) {
  Sheet sheet;
  sheet.paths.push_back({{{40, 100}, {80, 100}}, false, kThick, {}, {1.0}});
  sheet.paths.push_back({{{100, 100}, {140, 100}}, false, kThick, {}, {-1.0}});
  sheet.paths.push_back({{{160, 100}, {180, 100}, {180, 120}}, true, {0, 0, 0.2, {}}});
  sheet.paths.push_back({{{160, 200}, {180, 200}, {180, 220}}, true, kThick});
  sheet.line({40, 200}, {80, 200}, {0.5, 0, -1, {3.0, 5.0}});
  const ReadPage page(sheet_pdf(sheet));
  for (const double deg : {20, 45, 70, 90, 115, 160}) {
    const double rad = deg * std::numbers::pi / 180, x = std::cos(rad), y = std::sin(rad);
    for (const double inwards : {0.0, 0.6}) {
      const double radius = 20 - inwards;
      EXPECT_EQ(page.is_dark(60 + radius * x, 100 - radius * y), inwards == 0) << deg;
      EXPECT_EQ(page.is_dark(120 + radius * x, 100 + radius * y), inwards == 0) << deg;
    }
  }
  EXPECT_TRUE(page.is_dark(175, 105));
  EXPECT_FALSE(page.is_dark(165, 115));
  EXPECT_TRUE(page.is_dark(170, 210));  // the way back
  EXPECT_FALSE(page.is_dark(175, 210));
  EXPECT_TRUE(page.is_dark(41, 200));
  EXPECT_FALSE(page.is_dark(45.5, 200));
}

// Letters can be searched and copied, and stand where their anchors say by their real widths.
TEST(SheetPdf, KeepsLettersAndTheirPlaces) {
  Sheet sheet;
  sheet.texts = {{{100, 250}, "Łazienka", 4.0, 0, Sheet::Anchor::start},
                 {{100, 230}, "Κουζίνα", 4.0, 0, Sheet::Anchor::middle, true},
                 {{100, 210}, "Кухня", 4.0, 0, Sheet::Anchor::end},
                 {{100, 190}, "(a)\\", 4.0},
                 {{100, 170}, "12.34±0.05×m²", 4.0},
                 {{30, 100}, "Wwww", 4.0, std::numbers::pi / 2, Sheet::Anchor::middle}};
  const SheetPdf pdf = sheet_pdf(sheet);
  EXPECT_EQ(pdf.missing, "");
  const auto words = ReadPage(pdf).words();
  ASSERT_EQ(words.size(), sheet.texts.size());
  for (const Sheet::Text& text : sheet.texts) ASSERT_TRUE(words.contains(text.text)) << text.text;
  const auto box = [&words](const char* word) { return words.at(word); };
  EXPECT_NEAR(box("Łazienka").left, 100, 0.1);
  EXPECT_NEAR((box("Κουζίνα").left + box("Κουζίνα").right) / 2, 100, 0.1);
  EXPECT_NEAR(box("Кухня").right, 100, 0.1);
  EXPECT_LT(box("Łazienka").low, 250);  // descenders
  EXPECT_GT(box("Łazienka").high, 250 + 2);
  EXPECT_LT(box("Łazienka").high, 250 + 6);
  const ReadPage::Box upright = box("Wwww");
  EXPECT_NEAR((upright.low + upright.high) / 2, 100, 0.1);
  EXPECT_LT(upright.right, 30 + 2);
  EXPECT_GT(upright.high - upright.low, 2 * (upright.right - upright.left) * 0.7);
}

// U+F0000 is for private use.
TEST(SheetPdf, NamesLettersThatNoFontHas) {
  EXPECT_EQ(sheet_pdf(with_text("a\U000F0000b\U000F0000\U000F0001")).missing,
            "\U000F0000\U000F0001");
}

TEST(SheetPdf, IsTheSameAgain) {
  EXPECT_EQ(sheet_pdf(with_text("Hall")).bytes, sheet_pdf(with_text("Hall")).bytes);
  EXPECT_THAT(sheet_pdf(with_text("Hall")).bytes, Not(HasSubstr("CreationDate")));
}

}  // namespace
}  // namespace marco::plan
