#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/network/vision/detector.h"

namespace roomwise::labelling {

// The borders of a picture that cut a thing.
struct CutBorders {
  bool left = false, top = false, right = false, bottom = false;

  friend bool operator==(const CutBorders&, const CutBorders&) = default;
};

// A box that a reader drew about what is visible of a thing.
struct LabelledView {
  std::uint64_t frame = 0;  // index of the colour picture in its recording
  network::PixelBox box;
  CutBorders cut;
  bool is_occluded = false;  // another thing hides a part of it
};

// One physical thing, however often it is seen.
struct LabelledThing {
  std::int64_t id = 0;
  std::string name;
  bool is_name_sure = true;
  std::vector<std::string> sides;  // that were seen
  std::vector<LabelledView> views;
  std::string note;
  bool is_transient = false;  // a person: no thing of the home
};

// What one reader marked in the pictures of a recording (tests/truth/labels/README.md).
struct ReaderLabels {
  std::string recording, reader;
  std::vector<LabelledThing> things;
};

// Fails, naming the file and the thing, where a field is missing or of another type, a box is empty
// or not finite, a border has another name, or two things have one id.
[[nodiscard]] Expected<ReaderLabels> read_reader_labels(const std::filesystem::path& path);
// The same form.
[[nodiscard]] nlohmann::ordered_json to_json(const ReaderLabels& labels);

}  // namespace roomwise::labelling
