#pragma once

#include "laboratory/training/trainer.h"
#include "roomwise/evaluation/report/training_report.h"
#include "roomwise/network/formats/model_card.h"

namespace roomwise::app {

// Where a trained network and what belongs to it are written: NAME.onnx, NAME.card.json,
// NAME.labels.txt, NAME.training.html, and NAME.checkpoint while it is trained.
struct TrainedFiles {
  TrainedFiles(const std::filesystem::path& folder, const std::string& name);

  // Makes the folder. Fails where a file could not be written.
  [[nodiscard]] Expected<void> prepare() const;
  // The network last, so that where it stands the rest does too.
  [[nodiscard]] Expected<void> write(const network::OnnxGraph& graph,
                                     const network::ModelCard& card,
                                     const std::vector<std::string>& labels,
                                     const evaluation::TrainingReportContent& report) const;

  std::filesystem::path folder, network, card, labels, report, checkpoint;
};

}  // namespace roomwise::app
