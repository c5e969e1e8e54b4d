// What "train" does; see train_command.cpp for its options.
#include <cmath>
#include <ctime>
#include <memory>
#include <set>

#include "home_pictures.h"
#include "laboratory/training/head.h"
#include "laboratory/training/processes.h"
#include "laboratory/training/trainer.h"
#include "open_home.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/vision/compact_network.h"
#include "roomwise/pipeline/rooms/room_selection.h"
#include "train_command.h"
#include "trained_files.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using namespace training;

// Pictures to learn from and pictures that are held out.
struct Data {
  std::unique_ptr<TrainingData> whole;  // what the parts are of, if they are
  std::unique_ptr<TrainingData> training, held_out;
};

// The key-frames of these visits. Fails where there are none.
Expected<HomePictures> pictures_of_visits(const home::Home& home, const std::string& visits) {
  pipeline::RoomSelection selection;
  ROOMWISE_TRY(selection.stays, pipeline::parse_stays(visits));
  ROOMWISE_TRY(HomePictures pictures, HomePictures::read(home, [&](const auto& range) {
                 return selection.contains(range);
               }));
  if (pictures.size() == 0) {
    return fail("{}: no room has a key-frame in the visits {}; see roomwise info", home.file(),
                visits);
  }
  return pictures;
}

// The key-frames in named ranges, but for those of some visits, if any are given.
Expected<HomePictures> pictures_of_other_visits(const home::Home& home, const std::string& visits) {
  pipeline::RoomSelection left_out;
  if (!visits.empty()) {
    ROOMWISE_TRY(left_out.stays, pipeline::parse_stays(visits));
  }
  return HomePictures::read(home, [&](const recording::RoomRange& range) {
    return visits.empty() || !left_out.contains(range);
  });
}

// What a network was trained on says nothing about how it does on other pictures.
Expected<void> check_apart(const TrainingData& training, const TrainingData& held_out) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < training.size(); ++i) names.insert(training.name(i));
  for (std::size_t i = 0; i < held_out.size(); ++i) {
    if (!names.contains(held_out.name(i))) continue;
    return fail("{} is both to be trained on and held out; name other --visits or none",
                held_out.name(i));
  }
  return {};
}

template <typename Part>
std::unique_ptr<TrainingData> owned(Part part) {
  return std::make_unique<Part>(std::move(part));
}

Expected<Data> data_of_home(const TrainRequest& request, const Context& context) {
  Data data;
  ROOMWISE_TRY(const home::Home home, open_home_read_only(request.home, context));
  ROOMWISE_TRY(HomePictures training, request.visits.empty()
                                          ? pictures_of_other_visits(home, request.held_out_visits)
                                          : pictures_of_visits(home, request.visits));
  data.training = owned(std::move(training));
  if (request.held_out_visits.empty()) {
    data.held_out = owned(DataPart(*data.training, {}));
    return data;
  }
  ROOMWISE_TRY(HomePictures held_out, pictures_of_visits(home, request.held_out_visits));
  ROOMWISE_RETURN_IF_ERROR(check_apart(*data.training, held_out));
  data.held_out = owned(std::move(held_out));
  return data;
}

Expected<Data> data_of_folder(const TrainRequest& request) {
  Data data;
  ROOMWISE_TRY(PictureFolder folder, PictureFolder::open(request.folder));
  if (!request.held_out.empty()) {
    std::error_code ignored;
    if (fs::equivalent(request.folder, request.held_out, ignored)) {
      return fail("{} is both to be trained on and held out; name another folder with --held-out",
                  request.held_out.string());
    }
    ROOMWISE_TRY(PictureFolder held_out, PictureFolder::open(request.held_out));
    ROOMWISE_TRY(PictureFolder renumbered,
                 std::move(held_out).with_classes(folder.classes()).map_error([&](Error error) {
                   return std::move(error).with_context(request.held_out.string());
                 }));
    data.training = owned(std::move(folder));
    data.held_out = owned(std::move(renumbered));
    return data;
  }
  data.whole = owned(std::move(folder));
  DataSplit split = split_data(*data.whole, request.held_out_share, request.options.seed);
  data.training = owned(std::move(split.training));
  data.held_out = owned(std::move(split.held_out));
  return data;
}

// What the training begins with: a network's files, or for "compact" our own network of random
// weights.
Expected<network::NetworkFile> network_to_train(const TrainRequest& request) {
  if (request.network != kCompactNetwork) return network::read_network_in_floats(request.network);
  network::CompactOptions options;
  options.weights.seed = request.options.seed;
  network::NetworkFile file;
  file.card = network::compact_card();
  file.graph = network::compact_network(options);
  return file;
}

Expected<std::string> features_of(const TrainRequest& request, const network::ModelCard& card) {
  if (!request.features.empty()) return request.features;
  if (!card.features_outputs.empty()) return card.features_outputs.back();
  return fail("{}: its card names no features for a new last layer; name a node with --features",
              request.network.string());
}

evaluation::TrainingReportContent report_of(const TrainRequest& request,
                                            const TrainingResult& result, const Data& data,
                                            const std::string& name) {
  evaluation::TrainingReportContent content;
  content.network = name;
  const fs::path& source = request.home.empty() ? request.folder : request.home;
  content.figures = {
      {"Begun with", request.network.filename().string()},
      {"Trained from", request.options.from.empty() ? "the first layer" : request.options.from},
      {"Pictures", fmt::format("{} of {} classes in {}, {} more held out", data.training->size(),
                               data.training->classes().size(), source.filename().string(),
                               data.held_out->size())},
      {"Steps", fmt::format("{} of {} pictures", result.steps, request.options.batch)},
      {"Best step", data.held_out->size() == 0
                        ? std::to_string(result.best_step)
                        : fmt::format("{}, chosen on the held-out pictures themselves, which "
                                      "flatters their figures a little",
                                      result.best_step)}};
  for (const CurvePoint& point : result.curve) {
    content.points.push_back({static_cast<double>(point.step), point.cross_entropy,
                              point.held_out_cross_entropy, point.held_out_precision});
  }
  content.best_step = static_cast<double>(result.best_step);
  return content;
}

Json json_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Answer answer_of(const TrainingResult& result, const Data& data, const TrainedFiles& files,
                 double cpu_s) {
  Json curve = Json::array();
  Answer answer;
  for (const CurvePoint& point : result.curve) {
    curve.push_back({{"step", point.step},
                     {"cross_entropy", point.cross_entropy},
                     {"held_out_cross_entropy", json_or_null(point.held_out_cross_entropy)},
                     {"held_out_precision", json_or_null(point.held_out_precision)}});
    if (point.step != result.best_step) continue;
    answer.text =
        fmt::format("best after {} steps: cross-entropy {:.4f}", point.step, point.cross_entropy);
    if (data.held_out->size() > 0) {
      answer.text += fmt::format(
          ", of {} held out {:.4f}, precision {:.4f}\n(a little flattered: the best step was "
          "chosen "
          "on the held-out pictures themselves)",
          data.held_out->size(), point.held_out_cross_entropy, point.held_out_precision);
    }
    answer.text += "\n";
  }
  answer.text += fmt::format("{} classes: {}\nwrote {} and {}\n", data.training->classes().size(),
                             fmt::join(data.training->classes(), ", "), files.network.string(),
                             files.report.string());
  answer.json = {{"network", files.network.string()},
                 {"report", files.report.string()},
                 {"classes", data.training->classes()},
                 {"pictures", data.training->size()},
                 {"held_out", data.held_out->size()},
                 {"steps", result.steps},
                 {"best_step", result.best_step},
                 {"cpu_s", cpu_s},
                 {"curve", std::move(curve)}};
  return answer;
}

// As the network's card says, but for what is new.
network::ModelCard card_of(network::ModelCard card, const TrainingTask& task,
                           const std::string& features, const std::string& name,
                           const TrainedFiles& files) {
  card.source = fmt::format("{} fine-tuned by Roomwise on {} pictures ({})", card.name,
                            task.training->size(), card.source);
  card.name = name;
  card.features_outputs = {features};
  card.scores_output = task.logits;
  card.scores_need_softmax = true;
  card.labels_file = files.labels.filename().string();
  return card;
}

Expected<std::unique_ptr<Processes>> join_processes(Device device) {
  ROOMWISE_TRY(const auto place, ProcessPlace::from_environment());
  if (!place) return alone();
  ROOMWISE_TRY(const bool on_gpu, use_gpu(device));
  return Processes::join(*place, on_gpu);
}

}  // namespace

Expected<Answer> train_network(TrainRequest request, Context& context) {
  ROOMWISE_TRY(const Data data,
               request.home.empty() ? data_of_folder(request) : data_of_home(request, context));
  ROOMWISE_TRY(network::NetworkFile file, network_to_train(request));
  const auto in_file = [&](Error error) {
    return std::move(error).with_context(request.network.string());
  };
  ROOMWISE_TRY(const std::string features, features_of(request, file.card));
  const std::size_t classes = data.training->classes().size();
  ROOMWISE_TRY(NewHead head,
               with_new_head(std::move(file.graph), features, classes, request.options.seed)
                   .map_error(in_file));

  const std::string name = request.name.empty() ? file.card.name + "-trained" : request.name;
  const TrainedFiles files(request.output, name);
  TrainingOptions& options = request.options;
  options.checkpoint = files.checkpoint;
  if (!request.keeps_pictures) options.augmentation = {};
  options.augmentation.mirror = request.mirrors;
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_RETURN_IF_ERROR(files.prepare());
  std::error_code error;
  const bool was_stopped = fs::exists(files.checkpoint, error);
  if (error) return fail("{}: cannot be looked at: {}", files.checkpoint.string(), error.message());
  if (!options.resume && was_stopped) {
    return fail("{}: a training was stopped here; go on with --resume, or remove this file",
                files.checkpoint.string());
  }
  const TrainingTask task{std::move(head.graph), file.card,           head.logits,
                          head.aux_logits,       data.training.get(), data.held_out.get()};
  ROOMWISE_TRY(const auto processes, join_processes(options.device));
  ROOMWISE_TRY(const TrainingResult result,
               train(task, options, *processes, context.progress).map_error(in_file));
  if (!result.finished) {
    return fail_with(ErrorCode::kInterrupted,
                     "interrupted after {} of {} steps; the same command with --resume goes on",
                     result.steps, options.steps);
  }
  if (processes->rank() != 0)
    return Answer{"the process of rank 0 writes the network\n", {{"rank", processes->rank()}}};
  const network::ModelCard card = card_of(file.card, task, features, name, files);
  ROOMWISE_RETURN_IF_ERROR(files.write(result.graph, card, data.training->classes(),
                                       report_of(request, result, data, name)));
  fs::remove(files.checkpoint, error);
  if (error) return fail("{}: cannot be removed: {}", files.checkpoint.string(), error.message());
  return answer_of(result, data, files, static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
}

}  // namespace roomwise::app
