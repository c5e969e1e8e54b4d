#include <filesystem>

#include "camera_option.h"
#include "commands.h"
#include "laboratory/labelling/label_page.h"
#include "roomwise/objects/kinds/kinds.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct LabelOptions {
  fs::path recording;
  std::string camera;
  std::size_t pictures = labelling::LabelPageOptions{}.pictures;
  fs::path labels, output;
};

// The page that comes with the laboratory: ../share/roomwise/labelling of the program's.
Expected<fs::path> brought_page() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  fs::path page = program.parent_path().parent_path() / "share/roomwise/labelling";
  if (!fs::exists(page / "index.html", error)) {
    return fail("{}: the labelling page is not there; build with -DROOMWISE_BUILD_WEB=ON",
                page.string());
  }
  return page;
}

Expected<Answer> label(const LabelOptions& options, Context& /*context*/) {
  ROOMWISE_TRY(const fs::path page, brought_page());
  ROOMWISE_TRY(const auto camera, given_camera(options.camera));
  ROOMWISE_TRY(const auto recording,
               recording::open_recording(options.recording, {.camera = camera}));
  labelling::LabelPageOptions page_options{options.pictures, {}, std::nullopt};
  for (const objects::Kind& kind : objects::standard_kinds()) {
    page_options.words.push_back(kind.name);
  }
  if (!options.labels.empty()) {
    ROOMWISE_TRY(page_options.labels, labelling::read_reader_labels(options.labels));
  }
  ROOMWISE_TRY(const std::size_t pictures,
               write_label_page(*recording, page, page_options, options.output));
  const fs::path index = options.output / "index.html";
  Answer answer;
  answer.text = fmt::format(
      "{} pictures; open {} in a browser, and give the file that it saves to lift-labels\n",
      pictures, index.string());
  answer.json = {{"pictures", pictures}, {"page", index.string()}};
  return answer;
}

}  // namespace

void add_label_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<LabelOptions>(
      app, context, "label", "Make a page on which a person draws boxes about a recording's things",
      "roomwise-lab label office_walk -o to-label\n"
      "A browser opens to-label/index.html; what it saves, lift-labels takes.",
      label);
  command->add_option("recording", options.recording, "Recording of any kind")
      ->required()
      ->check(CLI::ExistingPath);
  add_camera_option(*command, options.camera, "the recording's own");
  add_setting(*command, "--pictures", options.pictures,
              "Pictures on the page, evenly spread over the recording", positive());
  command->add_option("--labels", options.labels, "A reader's file to go on from")
      ->check(CLI::ExistingFile);
  command->add_option("-o,--output", options.output, "New folder to write to")->required();
}

}  // namespace roomwise::app
