#pragma once

#include <filesystem>
#include <string>

#include "command.h"
#include "laboratory/training/training_options.h"

namespace roomwise::app {

// In the place of a network's file: our own compact network, from random weights.
inline constexpr const char* kCompactNetwork = "compact";

// What "train" was asked for.
struct TrainRequest {
  std::filesystem::path folder;  // of classes; or else
  std::filesystem::path home;    // whose named key-frames show its rooms
  std::string visits;  // of the home's rooms, to train on; empty: all that are not held out
  std::string held_out_visits;     // empty: none is held out
  std::filesystem::path held_out;  // folder of classes that is not trained on
  double held_out_share = 0.2;     // of the folder, where there is no other
  std::filesystem::path network;
  std::string features;  // empty: those of the network's card
  std::string name;      // of the new network; empty: the old one's and "-trained"
  std::filesystem::path output;
  bool keeps_pictures = false;  // as they are: no augmentation
  bool mirrors = false;
  training::TrainingOptions options;
};

// Declares "train".
void declare_train_command(CLI::App& app, Context& context);

// What "train" does, by libtorch.
[[nodiscard]] Expected<Answer> train_network(TrainRequest request, Context& context);

}  // namespace roomwise::app
