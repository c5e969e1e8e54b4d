#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>

namespace roomwise::evaluation {

// Text made safe for HTML and XML, in content and in attributes between quotes. Control characters,
// which XML cannot hold, become spaces.
[[nodiscard]] std::string escape_markup(std::string_view text);

constexpr int kColors = 8;  // of svg_style(): room-0 to room-7, dot-0 to dot-7

// A vector drawing, built shape by shape from back to front. Lengths are in px, x right and y down.
//
// `attributes` are written into the element as they are: class="..." with classes of svg_style(),
// or any of SVG's own (stroke-width="2").
class SvgDrawing {
 public:
  // The title says what the drawing shows, for those who do not see it.
  SvgDrawing(double width, double height, std::string_view title);

  void line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::string_view attributes);
  void polyline(std::span<const Eigen::Vector2d> points, std::string_view attributes);
  void rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size,
                 std::string_view attributes);
  void circle(const Eigen::Vector2d& centre, double radius, std::string_view attributes);
  void text(const Eigen::Vector2d& place, std::string_view text, std::string_view attributes);
  // A picture given as a data: address.
  void picture(const Eigen::Vector2d& corner, const Eigen::Vector2d& size,
               std::string_view address);

  [[nodiscard]] const Eigen::Vector2d& size() const { return size_; }
  // The whole <svg> element. It stands in an HTML page as it is.
  [[nodiscard]] std::string element() const;
  // The same as a file of its own, with the style that a page would hold.
  [[nodiscard]] std::string file() const;

 private:
  [[nodiscard]] std::string element(std::string_view style) const;

  Eigen::Vector2d size_;
  std::string title_;
  std::string shapes_;
};

// The CSS classes that the plots and maps of this module draw with, and a dark variant of the plots
// for those who ask for dark pages. A page holds it once.
[[nodiscard]] std::string_view svg_style();

}  // namespace roomwise::evaluation
