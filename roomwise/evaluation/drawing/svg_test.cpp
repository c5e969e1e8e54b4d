#include "roomwise/evaluation/drawing/svg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace roomwise::evaluation {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(EscapeMarkup, MakesTextSafe) {
  EXPECT_EQ(escape_markup("<b a=\"1\" c='2'>&</b>"),
            "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;&lt;/b&gt;");
  EXPECT_EQ(escape_markup("Küche"), "Küche");
  EXPECT_EQ(escape_markup(std::string("a\0b\nc\x7f", 6)), "a b c ");
}

TEST(SvgDrawing, WritesShapesInTheirOrder) {
  SvgDrawing drawing(100, 50.5, "A <drawing>");
  drawing.line({1, 2}, {3.256, -0.001}, "class=\"axis\"");
  drawing.polyline(std::vector<Eigen::Vector2d>{{0, 0}, {10, 5}}, "class=\"truth\"");
  drawing.rectangle({1, 1}, {2, 3}, "");
  drawing.circle({5, 6}, 7, "");
  drawing.text({8, 9}, "a < b", "class=\"label\"");
  drawing.picture({0, 0}, {4, 4}, "data:image/png;base64,AAAA");
  const std::string svg = drawing.element();
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 100 50.5\""));
  EXPECT_THAT(svg, HasSubstr("aria-label=\"A &lt;drawing&gt;\""));
  EXPECT_THAT(svg, HasSubstr("<title>A &lt;drawing&gt;</title>"));
  std::size_t place = 0;
  for (const char* shape :
       {"<line x1=\"1\" y1=\"2\" x2=\"3.26\" y2=\"0\" class=\"axis\"/>",
        "<polyline points=\"0,0 10,5\" fill=\"none\" class=\"truth\"/>",
        "<rect x=\"1\" y=\"1\" width=\"2\" height=\"3\" />", "<circle cx=\"5\" cy=\"6\" r=\"7\" />",
        "<text x=\"8\" y=\"9\" class=\"label\">a &lt; b</text>",
        "<image x=\"0\" y=\"0\" width=\"4\" height=\"4\" href=\"data:image/png;base64,AAAA\"/>"}) {
    const std::size_t found = svg.find(shape, place);
    ASSERT_NE(found, std::string::npos) << shape << " in " << svg;
    place = found;
  }
}

TEST(SvgDrawing, AFileBringsItsStyleAndAnElementDoesNot) {
  const SvgDrawing drawing(10, 10, "x");
  EXPECT_THAT(drawing.file(), HasSubstr(std::string(svg_style())));
  EXPECT_THAT(drawing.element(), Not(HasSubstr("<style>")));
}

}  // namespace
}  // namespace roomwise::evaluation
