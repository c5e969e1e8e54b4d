#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "roomwise/evaluation/statistics/confusion_matrix.h"
#include "roomwise/image/image.h"

// Parts of pages that say how well something was done. A page needs nothing else: no scripts, no
// requests, pictures inside. Written for everybody (WCAG 2.2 AA): headings in order, tables with
// captions and headed rows and columns, texts for pictures, light and dark by the reader's choice.
// All texts are given as they are to be read.
namespace roomwise::evaluation {

// What is told of something, as a name and its value: "Key-frames", "212".
struct NamedFigure {
  std::string name, value;
};

// The whole page: the title as its heading, then a paragraph a note, then the body, which is HTML.
[[nodiscard]] std::string report_page(std::string_view title, const std::vector<std::string>& notes,
                                      std::string_view body);

// What may be wider than the reader's screen, in a frame that scrolls and can be reached by keys.
// `kind`: "map" for a drawing that needs more width than a plot.
[[nodiscard]] std::string scrolling(std::string_view name, std::string_view html,
                                    std::string_view kind = "");

// Cells by rows; the first of each row heads it. The first `text_columns` hold text, the others
// numbers. `highlighted`: for each row the column of the cell that stands out, or empty.
[[nodiscard]] std::string report_table(std::string_view caption,
                                       const std::vector<std::string>& columns,
                                       const std::vector<std::vector<std::string>>& rows,
                                       std::size_t text_columns = 1,
                                       const std::vector<std::size_t>& highlighted = {});
// The same of figures, under "Figure" and "Value".
[[nodiscard]] std::string figure_table(std::string_view caption,
                                       const std::vector<NamedFigure>& figures,
                                       std::size_t text_columns = 1);
// How often each room was taken for which, with precision and recall; empty where nothing was
// counted. `rule`: whose answers they are.
[[nodiscard]] std::string confusion_table(std::string_view rule, const ConfusionMatrix& confusion);

// A picture within the page, 320 px wide at most; `alt`: what it shows, for who does not see it.
[[nodiscard]] std::string picture_element(const image::ColorImage& picture, std::string_view alt);

struct PictureNote {
  image::ColorImage picture;
  std::string alt;  // as picture_element() takes it
  std::string heading;
  std::string text;
};
// The pictures side by side, with what is said of them.
[[nodiscard]] std::string picture_list(const std::vector<PictureNote>& notes);

}  // namespace roomwise::evaluation
