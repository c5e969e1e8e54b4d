#include "laboratory/trials/room_fitting.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "laboratory/trials/logistic_regression.h"
#include "roomwise/base/file.h"
#include "roomwise/base/spread.h"
#include "roomwise/pipeline/rooms/predict_pictures.h"
#include "roomwise/pipeline/rooms/room_learning.h"

namespace roomwise::trials {
namespace {

namespace fs = std::filesystem;
using pipeline::LabelledPicture;

Expected<RoomCaseFiles> parse_room_case(const nlohmann::json& json, const fs::path& folder) {
  RoomCaseFiles files;
  files.name = json.at("name");
  files.source = json.at("source");
  files.is_real = json.at("real");
  files.home = folder / json.at("home").get<std::string>();
  for (const auto& test : json.at("known")) {
    files.tests.push_back({folder / test.at("folder").get<std::string>(),
                           test.value("visits", std::string()), false});
  }
  for (const auto& test : json.at("elsewhere")) {
    files.tests.push_back({folder / test.get<std::string>(), {}, true});
  }
  return files;
}

std::vector<std::string> all_rooms(const recording::RoomLabels& labels) {
  std::vector<std::string> rooms;
  for (const recording::RoomRange& range : labels.ranges()) rooms.push_back(range.room);
  return rooms;
}

Expected<std::vector<LabelledPicture>> known_pictures(const RoomTest& test) {
  std::vector<LabelledPicture> pictures;
  const fs::path labels_file = test.folder / "rooms.txt";
  if (!fs::exists(labels_file)) {
    ROOMWISE_TRY(const auto photos, pipeline::list_room_photos(test.folder));
    std::vector<std::string> rooms;
    for (const pipeline::RoomPhoto& photo : photos) rooms.push_back(photo.room);
    return pipeline::select_photos(test.folder, rooms);
  }
  ROOMWISE_TRY(const auto labels, recording::RoomLabels::read(labels_file));
  ROOMWISE_TRY(const auto recorded, pipeline::RecordedPictures::open(test.folder));
  if (!recorded.damaged.empty()) return fail("{}", recorded.damaged.front().why);
  pipeline::RoomSelection selection;
  if (!test.visits.empty()) {
    ROOMWISE_TRY(selection.stays, pipeline::parse_stays(test.visits));
  }
  ROOMWISE_RETURN_IF_ERROR(pipeline::add_frames(recorded, labels, {selection, 0}, all_rooms(labels),
                                                test.folder.filename().string(), pictures));
  return pictures;
}

Expected<std::vector<LabelledPicture>> pictures_of(const RoomTest& test,
                                                   std::size_t max_elsewhere) {
  if (!test.is_elsewhere) return known_pictures(test);
  std::vector<LabelledPicture> pictures;
  ROOMWISE_TRY(const auto damage, pipeline::add_unknown_pictures(test.folder, pictures));
  if (!damage.empty()) return fail("{}", damage.front());
  return spread_evenly(std::move(pictures), max_elsewhere);
}

// Of a case among its sort: real and simulated ones weigh 1 together.
double share_of(const RoomCase& one, std::span<const RoomCase* const> cases) {
  return 1.0 / static_cast<double>(std::ranges::count(cases, one.is_real, &RoomCase::is_real));
}

bool is_known(const SeenPicture& picture) {
  return picture.room >= 0;
}

// A cross-entropy's derivatives by the two weights of the opinion pool.
struct PoolDerivatives {
  Eigen::Vector2d gradient;
  Eigen::Matrix2d hessian;
};

// Adds those of one picture of a room.
void add_picture(const SeenPicture& picture, const rooms::RoomCalibration& calibration,
                 const rooms::RoomModel& model, double weight, PoolDerivatives& sum) {
  const Eigen::MatrixX2d opinions =
      rooms::pooled_opinions(picture.similarity, picture.regression, calibration);
  const Eigen::VectorXd probabilities =
      model.probabilities(picture.similarity, picture.regression, calibration);
  const Eigen::Vector2d mean = opinions.transpose() * probabilities;
  sum.gradient += weight * (mean - opinions.row(picture.room).transpose());
  sum.hessian += weight * (opinions.transpose() * probabilities.asDiagonal() * opinions -
                           mean * mean.transpose());
}

// By Newton's method: the cross-entropy is convex in both weights.
void fit_pool(std::span<const RoomCase* const> cases, rooms::RoomModel& model) {
  constexpr int kIterations = 30;
  constexpr double kRidge = 1e-6;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::Vector2d weights(model.similarity_weight, model.regression_weight);
    PoolDerivatives sum{kRidge * weights, kRidge * Eigen::Matrix2d::Identity()};
    for (const RoomCase* one : cases) {
      const auto known = std::ranges::count_if(one->pictures, is_known);
      const double weight = share_of(*one, cases) / static_cast<double>(known);
      for (const SeenPicture& picture : one->pictures) {
        if (is_known(picture)) add_picture(picture, one->calibration, model, weight, sum);
      }
    }
    const Eigen::Vector2d step = sum.hessian.ldlt().solve(sum.gradient);
    model.similarity_weight -= step[0];
    model.regression_weight -= step[1];
  }
}

// What speaks for a picture, as far as it means the same for all networks that the model is for.
std::vector<std::size_t> used_numbers(const rooms::RoomModel& model) {
  return model.network.empty() ? std::vector<std::size_t>{3, 4} : std::vector<std::size_t>{0, 1, 2};
}

// Whether pictures show one of the rooms: a row each, a 1 and then what speaks for it.
struct FamiliaritySamples {
  Eigen::MatrixXd rows;
  Eigen::VectorXd is_here, weights;
};

FamiliaritySamples familiarity_samples(std::span<const RoomCase* const> cases,
                                       std::span<const std::size_t> used) {
  Eigen::Index count = 0;
  for (const RoomCase* one : cases) count += static_cast<Eigen::Index>(one->pictures.size());
  FamiliaritySamples samples{
      Eigen::MatrixXd::Ones(count, static_cast<Eigen::Index>(used.size()) + 1),
      Eigen::VectorXd(count), Eigen::VectorXd(count)};
  Eigen::Index row = 0;
  for (const RoomCase* one : cases) {
    const auto known = std::ranges::count_if(one->pictures, is_known);
    const auto elsewhere = static_cast<std::ptrdiff_t>(one->pictures.size()) - known;
    for (const SeenPicture& picture : one->pictures) {
      const auto numbers = rooms::familiarity_numbers(picture.similarity, one->calibration);
      for (std::size_t i = 0; i < used.size(); ++i) {
        samples.rows(row, static_cast<Eigen::Index>(i) + 1) = numbers[used[i]];
      }
      samples.is_here[row] = is_known(picture) ? 1 : 0;
      samples.weights[row++] =
          share_of(*one, cases) / static_cast<double>(is_known(picture) ? known : elsewhere);
    }
  }
  samples.weights *= static_cast<double>(count) / samples.weights.sum();
  return samples;
}

void fit_familiarity(std::span<const RoomCase* const> cases, rooms::RoomModel& model) {
  constexpr double kPenalty = 1;
  constexpr double kBiasPenalty = 1e-6;
  constexpr double kMinScale = 1e-9;
  const std::vector<std::size_t> used = used_numbers(model);
  auto [rows, is_here, weights] = familiarity_samples(cases, used);
  const Eigen::RowVectorXd mean = rows.colwise().mean();
  const Eigen::RowVectorXd scale =
      ((rows.rowwise() - mean).colwise().squaredNorm() / static_cast<double>(rows.rows()))
          .cwiseSqrt()
          .cwiseMax(kMinScale);
  for (Eigen::Index i = 1; i < rows.cols(); ++i) {
    rows.col(i) = (rows.col(i).array() - mean[i]) / scale[i];
  }
  Eigen::VectorXd penalty = Eigen::VectorXd::Constant(rows.cols(), kPenalty);
  penalty[0] = kBiasPenalty;
  const Eigen::VectorXd fitted = logistic_regression(rows, is_here, weights, penalty);
  model.bias = fitted[0];
  for (std::size_t i = 0; i < used.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i) + 1;
    model.weights[used[i]] = fitted[column] / scale[column];
    model.bias -= model.weights[used[i]] * mean[column];
  }
}

// Below which a share of the pictures of the rooms lies, in every sort of homes.
double fit_reject(std::span<const RoomCase* const> cases, const rooms::RoomModel& model,
                  double share) {
  double lowest = 0;
  for (const bool is_real : {false, true}) {
    std::vector<std::pair<double, double>> log_odds;  // and weight
    double whole = 0;
    for (const RoomCase* one : cases) {
      const auto known = std::ranges::count_if(one->pictures, is_known);
      for (const SeenPicture& picture : one->pictures) {
        if (one->is_real != is_real || !is_known(picture)) continue;
        log_odds.emplace_back(
            model.familiarity(rooms::familiarity_numbers(picture.similarity, one->calibration)),
            1.0 / static_cast<double>(known));
        whole += log_odds.back().second;
      }
    }
    std::ranges::sort(log_odds);
    double below = 0;
    for (const auto& [value, weight] : log_odds) {
      below += weight;
      if (below <= share * whole) continue;
      lowest = std::min(lowest, value);
      break;
    }
  }
  return lowest;
}

bool is_as_asked(const RoomCounts& counts, const RoomFittingOptions& options) {
  return static_cast<double>(counts.named_right) >=
             options.min_precision * static_cast<double>(counts.named) &&
         static_cast<double>(counts.elsewhere_named) <=
             options.max_elsewhere_named * static_cast<double>(counts.elsewhere);
}

RoomCounts sum(std::span<const RoomCase* const> cases, bool is_real,
               const rooms::RoomModel& model) {
  RoomCounts sum;
  for (const RoomCase* one : cases) {
    if (one->is_real != is_real) continue;
    const RoomCounts counts = counts_of(*one, model);
    for (const auto member : {&RoomCounts::named, &RoomCounts::named_right, &RoomCounts::elsewhere,
                              &RoomCounts::elsewhere_named}) {
      sum.*member += counts.*member;
    }
  }
  return sum;
}

// The lowest probability from which on what is named is as asked, in every sort of homes.
double fit_min_probability(std::span<const RoomCase* const> cases, rooms::RoomModel model,
                           const RoomFittingOptions& options) {
  for (int percent = 50; percent < 99; ++percent) {
    model.min_probability = percent / 100.0;
    if (is_as_asked(sum(cases, false, model), options) &&
        is_as_asked(sum(cases, true, model), options)) {
      return model.min_probability;
    }
  }
  return 0.99;
}

double to_four_digits(double value) {
  return std::round(value * 1e4) / 1e4;
}

nlohmann::json json_of(const Eigen::VectorXd& values) {
  return std::vector<double>(values.begin(), values.end());
}
Eigen::VectorXd vector_of(const nlohmann::json& json) {
  const auto values = json.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

nlohmann::json json_of(const SeenPicture& picture) {
  return {{"room", picture.room},
          {"name", picture.name},
          {"of_rooms", json_of(picture.similarity.of_rooms)},
          {"whitened", picture.similarity.whitened_cosine},
          {"plain", picture.similarity.plain_cosine},
          {"regression", json_of(picture.regression)}};
}

// Every number of a calibration, by its name in the evidence.
constexpr std::array<std::pair<const char*, double rooms::RoomCalibration::*>, 5> kCalibration = {
    {{"temperature", &rooms::RoomCalibration::temperature},
     {"whitened_mean", &rooms::RoomCalibration::whitened_cosine_mean},
     {"whitened_deviation", &rooms::RoomCalibration::whitened_cosine_deviation},
     {"plain_mean", &rooms::RoomCalibration::plain_cosine_mean},
     {"plain_deviation", &rooms::RoomCalibration::plain_cosine_deviation}}};

Expected<RoomCase> parse_evidence(const nlohmann::json& json) {
  RoomCase one{json.at("case"),
               json.at("source"),
               json.at("real"),
               json.at("network"),
               json.at("rooms"),
               {},
               {}};
  for (const auto& [name, member] : kCalibration) {
    json.at("calibration").at(name).get_to(one.calibration.*member);
  }
  ROOMWISE_RETURN_IF_ERROR(one.calibration.validate());
  const auto rooms = static_cast<Eigen::Index>(one.rooms.size());
  for (const auto& seen : json.at("pictures")) {
    SeenPicture picture{seen.at("room"),
                        seen.at("name"),
                        {vector_of(seen.at("of_rooms")), seen.at("whitened"), seen.at("plain")},
                        vector_of(seen.at("regression"))};
    if (picture.similarity.of_rooms.size() != rooms || picture.regression.size() != rooms ||
        picture.room >= rooms) {
      return fail("picture {}: not one number a room", picture.name);
    }
    one.pictures.push_back(std::move(picture));
  }
  return one;
}

int place_of(const std::vector<std::string>& rooms, const std::string& room) {
  const auto found = std::ranges::find(rooms, room);
  return found == rooms.end() ? -1 : static_cast<int>(found - rooms.begin());
}

}  // namespace

RoomCounts counts_of(const RoomCase& one, const rooms::RoomModel& model) {
  RoomCounts counts;
  for (const SeenPicture& picture : one.pictures) {
    const rooms::PictureEvidence evidence{
        model.probabilities(picture.similarity, picture.regression, one.calibration),
        model.familiarity(rooms::familiarity_numbers(picture.similarity, one.calibration))};
    const rooms::RoomDecision decision = decide(evidence, one.rooms, model);
    const bool is_named = decision.verdict == rooms::Verdict::kRoom;
    const bool is_either = decision.verdict == rooms::Verdict::kEither;
    if (!is_known(picture)) {
      ++counts.elsewhere;
      counts.elsewhere_named += is_named ? 1 : 0;
      counts.elsewhere_either += is_either ? 1 : 0;
      continue;
    }
    const auto room = static_cast<Eigen::Index>(picture.room);
    const auto is_best = [&](const Eigen::VectorXd& scores) {
      return scores[room] == scores.maxCoeff() ? 1 : 0;
    };
    const bool is_allowed = decision.allows(one.rooms[static_cast<std::size_t>(picture.room)]);
    ++counts.known;
    counts.best_right += is_best(evidence.probabilities);
    counts.regression_right += is_best(picture.regression);
    counts.similarity_right += is_best(picture.similarity.of_rooms);
    counts.named += is_named ? 1 : 0;
    counts.named_right += is_named && is_allowed ? 1 : 0;
    counts.either += is_either ? 1 : 0;
    counts.either_right += is_either && is_allowed ? 1 : 0;
  }
  return counts;
}

Expected<rooms::RoomModel> fit_rooms(std::span<const RoomCase* const> cases,
                                     const std::string& network,
                                     const RoomFittingOptions& options) {
  for (const RoomCase* one : cases) {
    if (!one->network.starts_with(network)) {
      return fail("case \"{}\" was learned on {}, not on {}", one->name, one->network, network);
    }
    const auto known = std::ranges::count_if(one->pictures, is_known);
    if (known == 0 || known == static_cast<std::ptrdiff_t>(one->pictures.size())) {
      return fail("case \"{}\" has {} pictures of its rooms and {} of other places; give both",
                  one->name, known, static_cast<std::ptrdiff_t>(one->pictures.size()) - known);
    }
  }
  rooms::RoomModel model;
  model.network = network;
  fit_pool(cases, model);
  fit_familiarity(cases, model);
  model.reject_log_odds = fit_reject(cases, model, options.max_rejected);
  RoomFittingOptions asked = options;
  if (network.empty()) asked.max_elsewhere_named = options.max_elsewhere_named_any;
  model.min_probability = fit_min_probability(cases, model, asked);
  return model;
}

std::string to_json(std::span<const rooms::RoomModel> models, std::span<const RoomCase> fitted_on,
                    const RoomFittingOptions& options) {
  using Json = nlohmann::ordered_json;
  Json cases = Json::array(), fitted = Json::array();
  for (const RoomCase& one : fitted_on) {
    const auto known = std::ranges::count_if(one.pictures, is_known);
    cases.push_back({{"name", one.name},
                     {"source", one.source},
                     {"real", one.is_real},
                     {"pictures", known},
                     {"elsewhere", static_cast<std::ptrdiff_t>(one.pictures.size()) - known}});
  }
  for (const rooms::RoomModel& model : models) {
    Json weights = Json::object();
    for (std::size_t i = 0; i < model.weights.size(); ++i) {
      weights[std::string(rooms::kFamiliarityNames[i])] = to_four_digits(model.weights[i]);
    }
    fitted.push_back({{"network", model.network},
                      {"similarity_weight", to_four_digits(model.similarity_weight)},
                      {"regression_weight", to_four_digits(model.regression_weight)},
                      {"bias", to_four_digits(model.bias)},
                      {"weights", std::move(weights)},
                      {"min_probability", model.min_probability},
                      {"reject_log_odds", to_four_digits(model.reject_log_odds)}});
  }
  return Json{{"about",
               "How similarity, the paper's regression and how familiar a picture is decide about "
               "rooms, written by roomwise-lab fit-rooms; see docs/rooms.md."},
              {"fitted_on", std::move(cases)},
              {"min_precision", options.min_precision},
              {"max_elsewhere_named", options.max_elsewhere_named},
              {"max_elsewhere_named_any", options.max_elsewhere_named_any},
              {"max_rejected", options.max_rejected},
              {"models", std::move(fitted)}}
             .dump(1) +
         "\n";
}

std::string evidence_json(const RoomCase& one) {
  nlohmann::json json{{"case", one.name},
                      {"source", one.source},
                      {"real", one.is_real},
                      {"network", one.network},
                      {"rooms", one.rooms}};
  for (const auto& [name, member] : kCalibration) {
    json["calibration"][name] = one.calibration.*member;
  }
  for (const SeenPicture& picture : one.pictures) json["pictures"].push_back(json_of(picture));
  return json.dump();
}

Expected<std::vector<RoomCase>> read_room_evidence(const fs::path& file) {
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  std::vector<RoomCase> cases;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::string place = fmt::format("{}:{}", file.string(), cases.size() + 1);
    try {
      auto one = parse_evidence(nlohmann::json::parse(line));
      if (!one) return Unexpected(std::move(one).error().with_context(place));
      cases.push_back(*std::move(one));
    } catch (const nlohmann::json::exception& error) {
      return fail("{}: {}", place, error.what());
    }
  }
  return cases;
}

Expected<std::vector<RoomCaseFiles>> read_room_study(const fs::path& file) {
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  std::vector<RoomCaseFiles> cases;
  try {
    const nlohmann::json study = nlohmann::json::parse(text);
    for (const auto& json : study.at("cases")) {
      ROOMWISE_TRY(cases.emplace_back(), parse_room_case(json, file.parent_path()));
    }
  } catch (const nlohmann::json::exception& error) {
    return fail("{}: case {}: {}", file.string(), cases.size() + 1, error.what());
  }
  return cases;
}

Expected<RoomCase> room_case(const RoomCaseFiles& files, const home::Home& home,
                             const pipeline::Networks& networks, std::size_t max_elsewhere,
                             pipeline::RunContext& run) {
  ROOMWISE_TRY(const auto recognizer, pipeline::RoomRecognizer::create(home, networks));
  const std::string& learned_on = recognizer.classifier().network().name;
  RoomCase result{files.name,
                  files.source,
                  files.is_real,
                  learned_on.substr(0, learned_on.find(" (")),
                  recognizer.rooms(),
                  recognizer.calibration(),
                  {}};
  for (const RoomTest& test : files.tests) {
    ROOMWISE_TRY(const auto pictures, pictures_of(test, max_elsewhere));
    ROOMWISE_TRY(const auto seen,
                 pipeline::predict_pictures(
                     pictures.size(), [&](std::size_t i) { return pictures[i].read(); },
                     recognizer.features(), files.name, run));
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const auto& features = seen[i].prediction.features;
      const int room = test.is_elsewhere ? -1 : place_of(result.rooms, pictures[i].room);
      result.pictures.push_back(
          {room, pictures[i].name,
           recognizer.classifier().retrieval().gallery.compare(rooms::root_features(features)),
           recognizer.classifier()
               .regression()
               .probabilities(rooms::unit_length(features).transpose())
               .cast<double>()});
    }
  }
  return result;
}

}  // namespace roomwise::trials
