#include "train_command.h"

#include <map>

namespace roomwise::app {
namespace {

using training::Device;
using training::LearningRate;
using training::Optimizer;
using training::TrainingOptions;
using Schedule = LearningRate::Schedule;

template <typename Value>
CLI::Validator one_of(const std::map<std::string, Value>& words) {
  return CLI::CheckedTransformer(words).description("");
}

void add_data_options(CLI::App& command, TrainRequest& request) {
  CLI::Option* folder =
      command.add_option("FOLDER", request.folder, "Folder with one folder of pictures a class");
  CLI::Option* home =
      command
          .add_option("--home", request.home,
                      "Home whose rooms are the classes, shown by its key-frames in named ranges")
          ->excludes(folder);
  command
      .add_option("--visits", request.visits,
                  "Of --home: visits of a room to train on (1, 2- or 1-3); default: all that are "
                  "not held out")
      ->needs(home);
  command
      .add_option("--held-out-visits", request.held_out_visits,
                  "Of --home: visits that are held out; default: none")
      ->needs(home);
  CLI::Option* held_out =
      command
          .add_option("--held-out", request.held_out,
                      "Folder of the same classes, or of some of them, to find the best step "
                      "by")
          ->excludes(home);
  command
      .add_option("--held-out-share", request.held_out_share,
                  "Share of each class of FOLDER that is held out instead")
      ->excludes(home)
      ->excludes(held_out)
      ->check(CLI::Range(0.0, 0.9).description(""))
      ->capture_default_str();
}

void add_network_choice(CLI::App& command, TrainRequest& request) {
  command
      .add_option("--network", request.network,
                  "Network to begin with: an ONNX file with its card NAME.card.json beside it, or "
                  "compact: a small network of random weights, drawn by --seed")
      ->required();
  command.add_option("--features", request.features,
                     "Node whose values the new last layer takes; default: what the card names "
                     "last as features");
  command.add_option("--from-block", request.options.from,
                     "First node or block that is trained (logits: the new last layer alone); "
                     "default: all are");
  command.add_option("-o,--out", request.output, "Folder for the new network")->required();
  command.add_option("--name", request.name,
                     "Of the new network; default: the old one's with -trained");
  command.add_flag("--resume", request.options.resume,
                   "Go on from the checkpoint of a training that was stopped");
}

void add_course_options(CLI::App& command, TrainingOptions& options) {
  const auto add = [&](const char* name, auto& value, const char* meaning) {
    return add_setting(command, name, value, meaning);
  };
  add("--steps", options.steps, "Batches to learn from")->type_name("N");
  add("--batch", options.batch, "Pictures a step (of each process)")->type_name("N");
  add("--learning-rate", options.rate.base, "Learning rate");
  command
      .add_option("--schedule", options.rate.schedule,
                  "How the learning rate falls: constant, steps or cosine (default)")
      ->transform(one_of<Schedule>({{"constant", Schedule::kConstant},
                                    {"steps", Schedule::kSteps},
                                    {"cosine", Schedule::kCosine}}));
  add("--decay", options.rate.decay, "Of --schedule steps: factor");
  add("--decay-every", options.rate.decay_every, "Of --schedule steps: steps between")
      ->type_name("N");
  add("--warm-up", options.rate.warm_up_steps, "First steps, over which the learning rate rises")
      ->type_name("N");
  command.add_option("--optimizer", options.optimizer, "sgd (default), rmsprop or adam")
      ->transform(one_of<Optimizer>({{"sgd", Optimizer::kSgd},
                                     {"rmsprop", Optimizer::kRmsProp},
                                     {"adam", Optimizer::kAdam}}));
  add("--momentum", options.momentum, "Share of the last step that is added to the next");
  add("--weight-decay", options.weight_decay, "How strongly weights are drawn to 0");
  add("--label-smoothing", options.label_smoothing, "Share of certainty spread over all classes");
  add("--aux-weight", options.aux_weight, "Weight of the loss of a second head, if there is one");
}

void add_run_options(CLI::App& command, TrainRequest& request) {
  TrainingOptions& options = request.options;
  command.add_flag("--no-augmentation", request.keeps_pictures,
                   "Pictures as they are, not varied in light and direction");
  command.add_flag("--mirror", request.mirrors, "Mirror every second picture");
  const auto add = [&](const char* name, auto& value, const char* meaning) {
    add_setting(command, name, value, meaning)->type_name("N");
  };
  add("--evaluate-every", options.evaluate_every,
      "Steps between evaluations on the held-out pictures");
  add("--checkpoint-every", options.checkpoint_every,
      "Steps between checkpoints, from which --resume goes on");
  add("--loader-threads", options.loader_threads, "Threads that load and prepare pictures");
  command.add_option("--device", options.device, "auto (default), cpu or cuda")
      ->transform(one_of<Device>(
          {{"auto", Device::kAuto}, {"cpu", Device::kCpu}, {"cuda", Device::kCuda}}));
}

}  // namespace

void declare_train_command(CLI::App& app, Context& context) {
  const auto [command, request] = add_command<TrainRequest>(
      app, context, "train", "Fine-tune a network on pictures of your own classes",
      "roomwise train photos --network models/mobilenet-v2-imagenet.onnx --steps 500 --out "
      "trained\n"
      "Several processes, on one machine or more, train together where MASTER_ADDR, MASTER_PORT,\n"
      "RANK and WORLD_SIZE are set. The number of threads changes the last bits of the result.",
      [](const TrainRequest& given, Context& with) -> Expected<Answer> {
        if (given.folder.empty() && given.home.empty())
          return fail("there is nothing to learn from; give a FOLDER of classes or --home HOME");
        TrainRequest seeded = given;
        seeded.options.seed = with.seed;
        seeded.options.threads = static_cast<int>(with.threads);
        return train_network(std::move(seeded), with);
      });
  add_data_options(*command, request);
  add_network_choice(*command, request);
  add_course_options(*command, request.options);
  add_run_options(*command, request);
}

}  // namespace roomwise::app
