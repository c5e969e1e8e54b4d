#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "laboratory/labelling/reader_labels.h"
#include "roomwise/recording/recording.h"

// A folder with which a person marks the things in a recording: pictures, and a page that a browser
// opens as a file. What the page saves, lift_labels() takes.
namespace roomwise::labelling {

struct LabelPageOptions {
  std::size_t pictures = 60;       // evenly spread over the recording; all where it has fewer
  std::vector<std::string> words;  // names that the page offers
  // To go on from: their pictures are among those of the page.
  std::optional<ReaderLabels> labels;

  [[nodiscard]] Expected<void> validate() const;
};

// Writes the page of the folder `page`, which the build made (index.html, labelling.js,
// labelling.css), and the recording's pictures as it has them to `output`, which must be new or
// empty. Fails where the page's files are missing, a picture cannot be read, or the labels are of
// another recording. Returns the number of pictures.
[[nodiscard]] Expected<std::size_t> write_label_page(const recording::Recording& recording,
                                                     const std::filesystem::path& page,
                                                     const LabelPageOptions& options,
                                                     const std::filesystem::path& output);

}  // namespace roomwise::labelling
