#include "laboratory/labelling/label_page.h"

#include <nlohmann/json.hpp>
#include <set>

#include "roomwise/base/file.h"
#include "roomwise/base/spread.h"
#include "roomwise/image/codec.h"

namespace roomwise::labelling {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::set<std::uint64_t> chosen_pictures(const recording::Recording& recording,
                                        const LabelPageOptions& options) {
  const auto& all = recording.pictures();
  std::set<std::uint64_t> chosen;
  for (const std::size_t i : spread_evenly(all.size(), options.pictures)) {
    chosen.insert(all[i].index);
  }
  if (!options.labels) return chosen;
  for (const LabelledThing& thing : options.labels->things) {
    for (const LabelledView& view : thing.views) chosen.insert(view.frame);
  }
  return chosen;
}

Expected<Json> write_picture(const recording::Recording& recording, std::uint64_t index,
                             const fs::path& output) {
  const recording::RecordedPicture* const picture = recording.find(index);
  if (picture == nullptr) {
    return fail("frame {} of the labels: the recording has no such picture among its {}", index,
                recording.pictures().size());
  }
  ROOMWISE_TRY(const Bytes bytes, recording.read_color_file(index));
  const std::string file =
      fmt::format("pictures/{}.{}", index, image::is_png(bytes) ? "png" : "jpg");
  ROOMWISE_RETURN_IF_ERROR(write_file(output / file, bytes));
  const geometry::PinholeCamera camera = recording.original_camera(*picture);
  return Json{{"frame", index}, {"file", file}, {"width", camera.width}, {"height", camera.height}};
}

// As a script, since a page that is opened as a file may read no other. A "<" could end it.
std::string assignment(std::string_view name, const Json& value) {
  std::string text = value.dump();
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) {
    text.replace(at, 1, "\\u003c");
  }
  return fmt::format("window.{} = {};\n", name, text);
}

Expected<void> check_output(const fs::path& output) {
  std::error_code error;
  if (fs::exists(output, error) && !fs::is_empty(output, error)) {
    return fail("{}: is not empty; give a new folder", output.string());
  }
  fs::create_directories(output / "pictures", error);
  if (error) return fail("{}: cannot be made: {}", output.string(), error.message());
  return {};
}

}  // namespace

Expected<void> LabelPageOptions::validate() const {
  if (pictures == 0) return fail("pictures is 0; give one at least");
  return {};
}

Expected<std::size_t> write_label_page(const recording::Recording& recording, const fs::path& page,
                                       const LabelPageOptions& options, const fs::path& output) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  const std::string& name = recording.info().name;
  if (options.labels && options.labels->recording != name) {
    return fail("labels of {} do not belong to {}; give that recording's",
                options.labels->recording, name);
  }
  std::vector<std::pair<std::string, std::string>> files;
  for (const char* const file : {"labelling.css", "labelling.js", "index.html"}) {
    ROOMWISE_TRY(std::string text, read_text_file(page / file));
    files.emplace_back(file, std::move(text));
  }
  ROOMWISE_RETURN_IF_ERROR(check_output(output));
  Json pictures = Json::array();
  for (const std::uint64_t index : chosen_pictures(recording, options)) {
    ROOMWISE_TRY(pictures.emplace_back(), write_picture(recording, index, output));
  }
  std::string script =
      assignment("recording", {{"name", name}, {"pictures", pictures}, {"words", options.words}});
  if (options.labels) script += assignment("labels", to_json(*options.labels));
  ROOMWISE_RETURN_IF_ERROR(write_file(output / "recording.js", script));
  for (const auto& [file, text] : files) ROOMWISE_RETURN_IF_ERROR(write_file(output / file, text));
  return pictures.size();
}

}  // namespace roomwise::labelling
