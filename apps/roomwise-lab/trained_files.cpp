#include "trained_files.h"

#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/network/formats/onnx_writer.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

std::string json_of(const network::ModelCard& card) {
  const bool is_rgb = card.color_order == network::ColorOrder::kRgb;
  const bool stretches = card.fit == network::PictureFit::kStretch;
  const nlohmann::ordered_json json = {{"name", card.name},
                                       {"input",
                                        {{"width", card.input_width_px},
                                         {"height", card.input_height_px},
                                         {"colors", is_rgb ? "rgb" : "bgr"},
                                         {"fit", stretches ? "stretch" : "crop"}}},
                                       {"mean", card.mean},
                                       {"scale", card.scale},
                                       {"outputs",
                                        {{"features", card.features_outputs},
                                         {"scores", card.scores_output},
                                         {"softmax", card.scores_need_softmax}}},
                                       {"labels", card.labels_file},
                                       {"license", card.license},
                                       {"source", card.source}};
  return json.dump(2) + "\n";
}

}  // namespace

TrainedFiles::TrainedFiles(const fs::path& into, const std::string& name)
    : folder(into),
      network(into / (name + ".onnx")),
      card(into / (name + ".card.json")),
      labels(into / (name + ".labels.txt")),
      report(into / (name + ".training.html")),
      checkpoint(into / (name + ".checkpoint")) {}

Expected<void> TrainedFiles::prepare() const {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail("{}: cannot be made: {}", folder.string(), error.message());
  for (const fs::path& file : {network, card, labels, report, checkpoint})
    ROOMWISE_RETURN_IF_ERROR(check_can_write(file));
  return {};
}

Expected<void> TrainedFiles::write(const network::OnnxGraph& graph, const network::ModelCard& about,
                                   const std::vector<std::string>& names,
                                   const evaluation::TrainingReportContent& content) const {
  ROOMWISE_TRY(const Bytes onnx, network::write_onnx_graph(graph));
  ROOMWISE_RETURN_IF_ERROR(write_file(labels, fmt::format("{}\n", fmt::join(names, "\n"))));
  ROOMWISE_RETURN_IF_ERROR(write_file(card, json_of(about)));
  ROOMWISE_RETURN_IF_ERROR(write_file(report, evaluation::render_training_report(content)));
  return write_file(network, onnx);
}

}  // namespace roomwise::app
