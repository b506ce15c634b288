#include "plan/drawing/svg_path.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "plan/drawing/drawing.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

class PathReader {
 public:
  explicit PathReader(std::string_view data) : numbers_(data) {}

  std::vector<SvgChain> read() {
    char command = 0;
    while (!numbers_.at_end()) {
      const char letter = numbers_.letter();
      if (letter != 0) command = letter;
      require(letter != 0 || (command != 'Z' && command != 'z'),
              "contains a path with a stray number");
      require(command != 0 && (!chains_.empty() || command == 'M' || command == 'm'),
              "contains a path that does not begin with M");
      step(command);
      before_ = command;
      // Further points behind a move are lines.
      if (command == 'M') command = 'L';
      if (command == 'm') command = 'l';
    }
    return std::move(chains_);
  }

 private:
  static bool is_one_of(char command, std::string_view some) {
    return some.find(command) != std::string_view::npos;
  }

  Vector point(bool relative) {
    const double x = numbers_.number(), y = numbers_.number();
    return relative ? Vector(at_ + Vector(x, y)) : Vector(x, y);
  }

  void step(char command) {
    const bool relative = command >= 'a';
    switch (relative ? static_cast<char>(command - 'a' + 'A') : command) {
      case 'M':
        at_ = start_ = point(relative);
        begin();
        return;
      case 'Z':
        to(start_);
        is_closed_ = true;
        return;
      case 'L':
        return to(point(relative));
      case 'H':
        return to({numbers_.number() + (relative ? at_.x() : 0.0), at_.y()});
      case 'V':
        return to({at_.x(), numbers_.number() + (relative ? at_.y() : 0.0)});
      case 'C': {
        const Vector a = point(relative), b = point(relative);
        return cubic(a, b, point(relative));
      }
      case 'S': {
        const Vector a = is_one_of(before_, "CcSs") ? Vector(2 * at_ - steer_) : at_;
        const Vector b = point(relative);
        return cubic(a, b, point(relative));
      }
      case 'Q': {
        const Vector a = point(relative);
        return quadratic(a, point(relative));
      }
      case 'T': {
        const Vector a = is_one_of(before_, "QqTt") ? Vector(2 * at_ - steer_) : at_;
        return quadratic(a, point(relative));
      }
      case 'A':
        return arc(relative);
      default:
        throw std::invalid_argument("contains a path with an unknown command");
    }
  }

  void begin() {
    chains_.push_back({{at_}, {false}});
    is_closed_ = false;
  }

  void to(const Vector& next, bool curved = false) {
    if (is_closed_) begin();
    require(++points_ <= DrawingBuilder::kMostLines, "has more than two million lines");
    chains_.back().points.push_back(next);
    chains_.back().curved.push_back(curved);
    at_ = next;
  }

  void cubic(const Vector& a, const Vector& b, const Vector& end) {
    constexpr int kChords = 24;
    const Vector from = at_;
    for (int i = 1; i <= kChords; ++i) {
      const double t = static_cast<double>(i) / kChords, u = 1 - t;
      to(u * u * u * from + 3 * u * u * t * a + 3 * u * t * t * b + t * t * t * end, true);
    }
    steer_ = b;
  }

  void quadratic(const Vector& a, const Vector& end) {
    cubic(at_ + (a - at_) * 2 / 3, end + (a - end) * 2 / 3, end);
    steer_ = a;
  }

  // By the centre: SVG 1.1, appendix F.6.5.
  void arc(bool relative) {
    Vector radii(std::abs(numbers_.number()), 0);
    radii.y() = std::abs(numbers_.number());
    const double turn = std::remainder(numbers_.number(), 360.0) * std::numbers::pi / 180.0;
    const bool large = numbers_.flag(), sweep = numbers_.flag();
    const Vector end = point(relative);
    if (end == at_) return;
    if (radii.minCoeff() <= 0.0) return to(end);
    Eigen::Matrix2d axes;
    axes << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
    // On the unit circle.
    Vector half = (axes.transpose() * (at_ - end) / 2).cwiseQuotient(radii);
    const double reach = half.norm();
    if (reach > 1.0) {
      radii *= reach;
      half /= reach;
    }
    const double off = std::sqrt(std::max(0.0, 1.0 / half.squaredNorm() - 1.0));
    const Vector centre = (large != sweep ? 1.0 : -1.0) * off * Vector(half.y(), -half.x());
    const Vector first = half - centre, last = -half - centre;
    double span = std::atan2(first.x() * last.y() - first.y() * last.x(), first.dot(last));
    if (sweep && span < 0) span += 2 * std::numbers::pi;
    if (!sweep && span > 0) span -= 2 * std::numbers::pi;
    const double begin_rad = std::atan2(first.y(), first.x());
    const Vector middle = (at_ + end) / 2 + axes * centre.cwiseProduct(radii);
    const int chords = chords_of_span(span);
    for (int i = 1; i < chords; ++i) {
      const double angle = begin_rad + span * i / chords;
      to(middle + axes * Vector(std::cos(angle), std::sin(angle)).cwiseProduct(radii), true);
    }
    to(end, true);
  }

  SvgNumbers numbers_;
  std::vector<SvgChain> chains_;
  Vector at_ = {0, 0}, start_ = {0, 0}, steer_ = {0, 0};
  char before_ = 0;
  bool is_closed_ = false;
  std::size_t points_ = 0;
};

}  // namespace

void SvgNumbers::skip() {
  while (!rest_.empty() && std::string_view(" \t\r\n\f,").find(rest_.front()) != rest_.npos) {
    rest_.remove_prefix(1);
  }
}

bool SvgNumbers::at_end() {
  skip();
  return rest_.empty();
}

char SvgNumbers::letter() {
  skip();
  const char first = rest_.empty() ? '\0' : rest_.front();
  const bool is_letter = (first >= 'a' && first <= 'z') || (first >= 'A' && first <= 'Z');
  if (is_letter) rest_.remove_prefix(1);
  return is_letter ? first : '\0';
}

double SvgNumbers::number() {
  skip();
  if (!rest_.empty() && rest_.front() == '+') rest_.remove_prefix(1);
  double value = 0.0;
  const auto parsed = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
  require(parsed.ec == std::errc{} && std::abs(value) <= DrawingBuilder::kFarthest,
          "lacks a number");
  rest_.remove_prefix(static_cast<std::size_t>(parsed.ptr - rest_.data()));
  return value;
}

bool SvgNumbers::flag() {
  skip();
  require(!rest_.empty() && (rest_.front() == '0' || rest_.front() == '1'),
          "contains an arc without its flags");
  const bool is_set = rest_.front() == '1';
  rest_.remove_prefix(1);
  return is_set;
}

std::vector<SvgChain> read_svg_path(std::string_view data) { return PathReader(data).read(); }

}  // namespace marco::plan
