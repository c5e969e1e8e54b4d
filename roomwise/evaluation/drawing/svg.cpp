#include "roomwise/evaluation/drawing/svg.h"

#include <fmt/format.h>

namespace roomwise::evaluation {
namespace {

// A hundredth of a px is finer than any screen.
std::string number(double value) {
  std::string text = fmt::format("{:.2f}", value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text == "-0" ? "0" : text;
}

}  // namespace

std::string escape_markup(std::string_view text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        safe += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    }
  }
  return safe;
}

SvgDrawing::SvgDrawing(double width, double height, std::string_view title)
    : size_(width, height), title_(escape_markup(title)) {}

void SvgDrawing::line(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                      std::string_view attributes) {
  shapes_ += fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" {}/>\n", number(from.x()),
                         number(from.y()), number(to.x()), number(to.y()), attributes);
}

void SvgDrawing::polyline(std::span<const Eigen::Vector2d> points, std::string_view attributes) {
  shapes_ += "<polyline points=\"";
  for (std::size_t i = 0; i < points.size(); ++i) {
    shapes_ +=
        fmt::format("{}{},{}", i == 0 ? "" : " ", number(points[i].x()), number(points[i].y()));
  }
  shapes_ += fmt::format("\" fill=\"none\" {}/>\n", attributes);
}

void SvgDrawing::rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size,
                           std::string_view attributes) {
  shapes_ +=
      fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {}/>\n", number(corner.x()),
                  number(corner.y()), number(size.x()), number(size.y()), attributes);
}

void SvgDrawing::circle(const Eigen::Vector2d& centre, double radius, std::string_view attributes) {
  shapes_ += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {}/>\n", number(centre.x()),
                         number(centre.y()), number(radius), attributes);
}

void SvgDrawing::text(const Eigen::Vector2d& place, std::string_view text,
                      std::string_view attributes) {
  shapes_ += fmt::format("<text x=\"{}\" y=\"{}\" {}>{}</text>\n", number(place.x()),
                         number(place.y()), attributes, escape_markup(text));
}

void SvgDrawing::picture(const Eigen::Vector2d& corner, const Eigen::Vector2d& size,
                         std::string_view address) {
  shapes_ += fmt::format("<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" href=\"{}\"/>\n",
                         number(corner.x()), number(corner.y()), number(size.x()), number(size.y()),
                         address);
}

std::string SvgDrawing::element() const {
  return element("");
}

std::string SvgDrawing::file() const {
  return element(fmt::format("<style>\n{}</style>\n", svg_style()));
}

std::string SvgDrawing::element(std::string_view style) const {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"drawing\" viewBox=\"0 0 {0} {1}\" "
      "width=\"{0}\" height=\"{1}\" role=\"img\" aria-label=\"{2}\">\n<title>{2}</title>\n{3}{4}"
      "</svg>\n",
      number(size_.x()), number(size_.y()), title_, style, shapes_);
}

std::string_view svg_style() {
  // The rooms' colours have a contrast of 5 or more to the map's light ground (WCAG 2.2 asks for 3
  // of graphics). Dashes and names tell the rooms apart as well.
  return R"(.drawing text { font: 14px system-ui, "DejaVu Sans", sans-serif; fill: #1a1a1a; }
.drawing .paper { fill: #ffffff; }
.drawing .grid { stroke: #dddddd; stroke-width: 1; }
.drawing .axis { stroke: #555555; stroke-width: 1; }
.drawing .heading { font-size: 17px; font-weight: 600; }
.drawing .middle { text-anchor: middle; }
.drawing .end { text-anchor: end; }
.drawing .truth { stroke: #000000; stroke-width: 2; }
.drawing .estimate { stroke: #0b57d0; stroke-width: 1.5; }
.drawing .difference { stroke: #d3221b; stroke-width: 1; }
@media (prefers-color-scheme: dark) {
.drawing text { fill: #eeeeee; }
.drawing .paper { fill: #1c1c1e; }
.drawing .grid { stroke: #3a3a3c; }
.drawing .axis { stroke: #aaaaaa; }
.drawing .truth { stroke: #ffffff; }
.drawing .estimate { stroke: #7aa9ff; }
.drawing .difference { stroke: #ff6961; }
}
.drawing .map-paper { fill: #f2f2ef; }
.drawing .on-map { fill: #111111; font-size: 20px; paint-order: stroke; stroke: #ffffff; stroke-width: 5px; stroke-linejoin: round; }
.drawing .room-name { font-size: 28px; font-weight: 700; }
.drawing .casing { stroke: #ffffff; stroke-width: 8; stroke-linejoin: round; stroke-linecap: round; }
.drawing .path { stroke-width: 4; stroke-linejoin: round; }
.drawing .key-frame { stroke: #ffffff; stroke-width: 1.5; }
.drawing .object { fill: #ffffff; stroke: #111111; stroke-width: 2.5; }
.drawing .object-number { fill: #111111; font-size: 18px; font-weight: 700; }
.drawing .ruler { stroke: #111111; stroke-width: 4; }
.drawing .room-0 { stroke: #0b5394; } .drawing .dot-0 { fill: #0b5394; }
.drawing .room-1 { stroke: #a63603; } .drawing .dot-1 { fill: #a63603; }
.drawing .room-2 { stroke: #166534; } .drawing .dot-2 { fill: #166534; }
.drawing .room-3 { stroke: #9d174d; } .drawing .dot-3 { fill: #9d174d; }
.drawing .room-4 { stroke: #5b21b6; } .drawing .dot-4 { fill: #5b21b6; }
.drawing .room-5 { stroke: #0e6e69; } .drawing .dot-5 { fill: #0e6e69; }
.drawing .room-6 { stroke: #6b4423; } .drawing .dot-6 { fill: #6b4423; }
.drawing .room-7 { stroke: #b91c1c; } .drawing .dot-7 { fill: #b91c1c; }
.drawing .room-none { stroke: #4b5563; } .drawing .dot-none { fill: #4b5563; }
)";
}

}  // namespace roomwise::evaluation
