// Whether networks believe the furniture of made-up homes: views of single pieces in their rooms,
// of the paper's seven kinds, named by MobileNetV2 and found by NanoDet-Plus:
//   furniture_recognition [HOMES]      default: 20, those of the seeds from 1, by day
// Homes are of a bedroom, a kitchen, a toilet and a hall unless --rooms names others.
// The networks lie in --models or ROOMWISE_MODELS. Beside the ideal picture, the same view through
// the sensor's faults and the blur of a moving hand. Same figures on every run, at any number of
// threads.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <map>
#include <opencv2/core/utility.hpp>
#include <optional>

#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/recording/simulate_recording.h"
#include "laboratory/simulation/walk/piece_views.h"
#include "roomwise/base/file.h"
#include "roomwise/evaluation/statistics/proportion.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"
#include "roomwise/network/vision/detector.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "roomwise/objects/detection/object_vocabulary.h"

namespace {

using namespace roomwise;
using evaluation::Proportion;
using network::PixelBox;
using simulation::HomeModel;
using simulation::RenderedFrame;

struct Options {
  std::uint64_t homes = 20;
  std::vector<std::string> rooms{"bedroom", "kitchen", "toilet"};  // a hall is added
  std::filesystem::path models;
  std::filesystem::path pictures;     // empty: none are written
  std::filesystem::path light_cache;  // a folder; empty: light is baked anew
  double bake_effort = 0.5;
  std::size_t views = 3;  // of a piece, at most
};

// A kind of the paper, ImageNet's labels that mean it, and COCO's.
struct Kind {
  std::string_view name;
  std::vector<std::string_view> labels;
  std::string_view detector_label = {};  // empty: COCO has no such class
};

const std::array kKinds{
    Kind{"bed", {"four-poster", "studio couch", "quilt", "pillow"}, "bed"},
    Kind{"lamp", {"table lamp", "lampshade"}},
    Kind{"wardrobe", {"wardrobe", "chiffonier", "china cabinet", "sliding door", "medicine chest"}},
    Kind{"microwave", {"microwave"}, "microwave"},
    Kind{"stove", {"stove", "microwave", "rotisserie"}, "oven"},
    Kind{"fridge", {"refrigerator"}, "refrigerator"},
    Kind{"toilet", {"toilet seat"}, "toilet"},
};

constexpr float kMinScore = 0.35F, kMinOverlap = 0.4F;  // of what counts as found

// What was made of one view.
struct Picture {
  std::size_t kind = 0;
  bool is_ideal = true;
  std::string model, name;  // of the furniture; of the view
  image::ColorImage image;
  PixelBox box;  // of the piece's pixels
};

struct Verdict {
  std::vector<std::string> center, tight;  // the best labels
  std::vector<network::Detection> found;
  float best_overlap = 0;  // of what was found of the right class
};

struct Tally {
  std::uint64_t views = 0;
  Proportion center_first, center_three, tight_first, tight_three, found;
};
// Of the ideal picture, and of the sensor's.
using Tallies = std::array<Tally, 2>;

struct Networks {
  std::unique_ptr<network::OnnxClassifier> classifier;
  std::unique_ptr<network::Detector> detector;
};

PixelBox box_of(const image::Image<std::uint16_t>& objects, std::size_t object) {
  PixelBox box{static_cast<float>(objects.width()), static_cast<float>(objects.height()), 0, 0};
  for (int y = 0; y < objects.height(); ++y) {
    for (int x = 0; x < objects.width(); ++x) {
      if (objects.at(x, y) != object + 1) continue;
      box.left = std::min(box.left, static_cast<float>(x));
      box.top = std::min(box.top, static_cast<float>(y));
      box.right = std::max(box.right, static_cast<float>(x + 1));
      box.bottom = std::max(box.bottom, static_cast<float>(y + 1));
    }
  }
  return box;
}

// The largest square in the picture's middle.
image::ColorImage center_crop(const image::ColorImage& image) {
  const int side = std::min(image.width(), image.height());
  return image::crop(image, (image.width() - side) / 2, (image.height() - side) / 2, side, side);
}

// A square a little larger than the piece, as far as the picture reaches.
image::ColorImage tight_crop(const image::ColorImage& image, const PixelBox& box) {
  constexpr float kMargin = 1.15F;
  const float longest = std::max(box.right - box.left, box.bottom - box.top);
  const int side =
      std::clamp(static_cast<int>(kMargin * longest), 1, std::min(image.width(), image.height()));
  const auto begin = [side](float from, float to, int size) {
    return std::clamp(static_cast<int>((from + to) / 2) - side / 2, 0, size - side);
  };
  return image::crop(image, begin(box.left, box.right, image.width()),
                     begin(box.top, box.bottom, image.height()), side, side);
}

Expected<std::vector<std::string>> best_labels(const network::OnnxClassifier& classifier,
                                               const image::ColorImage& image) {
  constexpr std::size_t kBest = 3;
  ROOMWISE_TRY(const network::Prediction prediction, classifier.predict(image));
  std::vector<std::size_t> order(prediction.scores.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, std::greater{},
                           [&](std::size_t i) { return prediction.scores[i]; });
  std::vector<std::string> best;
  for (const std::size_t i : std::span(order).first(kBest)) {
    best.push_back(classifier.labels()[i]);
  }
  return best;
}

Expected<Verdict> judge(const Networks& networks, const Picture& picture) {
  Verdict verdict;
  ROOMWISE_TRY(verdict.center, best_labels(*networks.classifier, center_crop(picture.image)));
  ROOMWISE_TRY(verdict.tight,
               best_labels(*networks.classifier, tight_crop(picture.image, picture.box)));
  ROOMWISE_TRY(verdict.found, networks.detector->detect(picture.image, kMinScore));
  for (const network::Detection& detection : verdict.found) {
    if (networks.detector->labels()[detection.label] != kKinds[picture.kind].detector_label) {
      continue;
    }
    verdict.best_overlap = std::max(verdict.best_overlap,
                                    network::intersection_over_union(detection.box, picture.box));
  }
  return verdict;
}

bool is_named(const Kind& kind, std::span<const std::string> labels) {
  return std::ranges::any_of(labels, [&](const std::string& label) {
    return std::ranges::any_of(kind.labels, [&](std::string_view accepted) {
      return objects::same_label(label, accepted);
    });
  });
}

void count(const Kind& kind, const Verdict& verdict, Tally& tally) {
  ++tally.views;
  const auto first = [](const std::vector<std::string>& labels) {
    return std::span(labels).first(1);
  };
  tally.center_first.add(is_named(kind, first(verdict.center)));
  tally.center_three.add(is_named(kind, verdict.center));
  tally.tight_first.add(is_named(kind, first(verdict.tight)));
  tally.tight_three.add(is_named(kind, verdict.tight));
  if (!kind.detector_label.empty()) tally.found.add(verdict.best_overlap > kMinOverlap);
}

// The colour as it is but for exposure and white balance, which every camera has.
simulation::SensorOptions ideal_sensor() {
  simulation::SensorOptions options = simulation::SensorOptions::ideal();
  options.auto_exposure = options.auto_white_balance = options.soft_shoulder = true;
  return options;
}

class Recognition {
 public:
  static Expected<std::unique_ptr<Recognition>> create(const Options& options) {
    ROOMWISE_TRY(auto catalogue, simulation::FurnitureCatalogue::open());
    Networks networks;
    ROOMWISE_TRY(networks.classifier,
                 network::OnnxClassifier::load(options.models / "mobilenet-v2-imagenet.onnx"));
    ROOMWISE_TRY(networks.detector,
                 network::Detector::load(options.models / "nanodet-plus-m-416.onnx"));
    for (const std::filesystem::path& folder : {options.pictures, options.light_cache}) {
      if (!folder.empty()) std::filesystem::create_directories(folder);
    }
    return std::unique_ptr<Recognition>(
        new Recognition(options, std::move(catalogue), std::move(networks)));
  }

  Expected<void> look_around(std::uint64_t seed) {
    simulation::HomeOptions home_options{seed, {}};
    for (const std::string& room : options_.rooms) {
      ROOMWISE_TRY(const simulation::RoomKind kind, simulation::parse_room_kind(room));
      home_options.rooms.push_back(kind);
    }
    ROOMWISE_TRY(const HomeModel home, simulation::generate_home(home_options, catalogue_));
    simulation::RenderOptions render;
    render.bake_effort = options_.bake_effort;
    if (!options_.light_cache.empty()) {
      render.light_cache = options_.light_cache / fmt::format("home-{}.light", seed);
    }
    SilentProgress silent;
    ROOMWISE_TRY(const auto renderer,
                 simulation::Renderer::create(home, catalogue_, render, pool_, silent));
    const auto space = simulation::FreeSpace::of(home);
    for (std::size_t i = 0; i < home.objects.size(); ++i) {
      const auto kind = std::ranges::find(kKinds, home.objects[i].kind, &Kind::name);
      if (kind == kKinds.end()) continue;
      ROOMWISE_RETURN_IF_ERROR(look_at(home, i, static_cast<std::size_t>(kind - kKinds.begin()),
                                       seed, space, *renderer));
    }
    return {};
  }

  [[nodiscard]] Expected<void> finish() const {
    print();
    if (options_.pictures.empty()) return {};
    return write_file(options_.pictures / "views.txt", listing_);
  }

 private:
  Recognition(const Options& options, simulation::FurnitureCatalogue catalogue, Networks networks)
      : options_(options),
        catalogue_(std::move(catalogue)),
        networks_(std::move(networks)),
        camera_(simulation::SimulationOptions::default_camera()) {}

  Expected<void> look_at(const HomeModel& home, std::size_t object, std::size_t kind,
                         std::uint64_t seed, const simulation::FreeSpace& space,
                         const simulation::Renderer& renderer) {
    const simulation::PlacedObject& piece = home.objects[object];
    ROOMWISE_TRY(const simulation::TriangleMesh mesh, catalogue_.load(piece.model));
    const auto views =
        simulation::find_views(home, object, mesh, space, renderer, camera_, options_.views, pool_);
    Pieces& pieces = pieces_[kind];
    ++pieces.all;
    if (views.empty()) ++pieces.unseen;
    std::vector<Picture> pictures;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const RenderedFrame seen = renderer.render(camera_, views[v].world_from_camera, pool_);
      const simulation::WalkPose pose =
          simulation::moving_pose(views[v].world_from_camera, piece.room);
      Picture picture{kind, true, piece.model, {}, {}, box_of(seen.object, object)};
      picture.name = fmt::format("{}-home-{}-{}-{}", kKinds[kind].name, seed, object, v);
      simulation::SensorOptions faults;
      faults.seed = seed;
      const std::uint64_t index = object * options_.views + v;
      for (const auto& sensor_options : {ideal_sensor(), faults}) {
        ROOMWISE_TRY(const auto sensor, simulation::Sensor::create(camera_, sensor_options));
        simulation::ExposureControl exposure(sensor_options);
        picture.image =
            sensor.capture(seen, pose, index, exposure.next(seen, 0, index), pool_).color;
        pictures.push_back(picture);
        picture.is_ideal = false;
      }
    }
    return judge_all(pictures, views);
  }

  Expected<void> judge_all(std::span<const Picture> pictures,
                           std::span<const simulation::PieceView> views) {
    std::vector<Expected<Verdict>> verdicts(pictures.size());
    pool_.parallel_for(pictures.size(),
                       [&](std::size_t i) { verdicts[i] = judge(networks_, pictures[i]); });
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      ROOMWISE_TRY(const Verdict verdict, std::move(verdicts[i]));
      const Picture& picture = pictures[i];
      const std::size_t column = picture.is_ideal ? 0 : 1;
      count(kKinds[picture.kind], verdict, by_kind_[picture.kind][column]);
      count(kKinds[picture.kind], verdict, by_model_[{picture.kind, picture.model}][column]);
      if (!options_.pictures.empty()) {
        ROOMWISE_RETURN_IF_ERROR(keep(picture, verdict, views[i / 2]));
      }
    }
    return {};
  }

  Expected<void> keep(const Picture& picture, const Verdict& verdict,
                      const simulation::PieceView& view) {
    const Kind& kind = kKinds[picture.kind];
    const std::string name = picture.name + (picture.is_ideal ? ".jpg" : "-sensor.jpg");
    std::string found;
    for (const network::Detection& detection : verdict.found) {
      found +=
          fmt::format(" {} {:.2f}", networks_.detector->labels()[detection.label], detection.score);
    }
    listing_ += fmt::format(
        "{} {} {:.1f} m, {:.0f} degrees, {:.0f} % seen; center {}: {}; tight {}: {}; {}:{}\n", name,
        picture.model, view.distance_m, view.aside_rad * 57.29578, 100 * view.share_seen,
        is_named(kind, verdict.center) ? "right" : "WRONG", fmt::join(verdict.center, " | "),
        is_named(kind, verdict.tight) ? "right" : "WRONG", fmt::join(verdict.tight, " | "),
        kind.detector_label.empty()          ? "detector"
        : verdict.best_overlap > kMinOverlap ? "found"
                                             : "NOT FOUND",
        found);
    constexpr int kQuality = 90;
    return write_file(options_.pictures / name, image::encode_jpeg(picture.image, kQuality));
  }

  static std::string percent(const Proportion& proportion) {
    if (proportion.n == 0) return "-";
    const evaluation::Interval interval = proportion.wilson_interval();
    return fmt::format("{:.0f} ({:.0f} to {:.0f})", 100 * proportion.value(), 100 * interval.low,
                       100 * interval.high);
  }

  static std::string columns(const Tally& tally) {
    return fmt::format("{:.0f} / {} | {:.0f} / {} | {}", 100 * tally.center_first.value(),
                       percent(tally.center_three), 100 * tally.tight_first.value(),
                       percent(tally.tight_three), percent(tally.found));
  }

  // The mean of the kinds, each counting the same.
  [[nodiscard]] std::string mean_columns(std::size_t column) const {
    const auto mean = [&](Proportion Tally::*figure) {
      double sum = 0, kinds = 0;
      for (const Tallies& tallies : by_kind_) {
        if ((tallies[column].*figure).n == 0) continue;
        sum += 100 * (tallies[column].*figure).value();
        ++kinds;
      }
      return kinds > 0 ? sum / kinds : 0;
    };
    return fmt::format("{:.0f} / {:.0f} | {:.0f} / {:.0f} | {:.0f}", mean(&Tally::center_first),
                       mean(&Tally::center_three), mean(&Tally::tight_first),
                       mean(&Tally::tight_three), mean(&Tally::found));
  }

  void print() const {
    constexpr std::array<std::string_view, 2> kTitles{"Ideal picture",
                                                      "With the sensor's faults and motion blur"};
    for (std::size_t column = 0; column < kTitles.size(); ++column) {
      fmt::print(
          "{}{}: top-1 / top-3, %, with Wilson's 95 % interval\n\n"
          "| kind | pieces, of these without a view | models | views | centre crop | tight crop | "
          "NanoDet-Plus |\n| --- | --- | --- | --- | --- | --- | --- |\n",
          column == 0 ? "" : "\n", kTitles[column]);
      for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
        const auto models = std::ranges::count_if(
            by_model_, [&](const auto& entry) { return entry.first.first == kind; });
        fmt::print("| {} | {}, {} | {} | {} | {} |\n", kKinds[kind].name, pieces_[kind].all,
                   pieces_[kind].unseen, models, by_kind_[kind][column].views,
                   columns(by_kind_[kind][column]));
      }
      fmt::print("| mean of kinds | | | | {} |\n", mean_columns(column));
    }
    fmt::print(
        "\nBy model: ideal picture, then the sensor's\n\n"
        "| model | views | centre crop | tight crop | NanoDet-Plus | centre crop | tight crop | "
        "NanoDet-Plus |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n");
    for (const auto& [model, tallies] : by_model_) {
      fmt::print("| {} {} | {} | {} | {} |\n", kKinds[model.first].name, model.second,
                 tallies[0].views, columns(tallies[0]), columns(tallies[1]));
    }
  }

  struct Pieces {
    std::uint64_t all = 0, unseen = 0;
  };

  Options options_;
  simulation::FurnitureCatalogue catalogue_;
  Networks networks_;
  geometry::PinholeCamera camera_;
  ThreadPool pool_{ThreadPool::default_size()};
  std::array<Pieces, kKinds.size()> pieces_;
  std::array<Tallies, kKinds.size()> by_kind_;
  std::map<std::pair<std::size_t, std::string>, Tallies> by_model_;
  std::string listing_;  // of the views
};

Expected<void> run(Options options) {
  if (options.models.empty()) {
    const auto folder = network::default_model_folder();
    if (!folder) return fail("no networks: name their folder by --models or ROOMWISE_MODELS");
    options.models = *folder;
  }
  cv::setNumThreads(1);
  ROOMWISE_TRY(const auto recognition, Recognition::create(options));
  for (std::uint64_t seed = 1; seed <= options.homes; ++seed) {
    ROOMWISE_RETURN_IF_ERROR(recognition->look_around(seed));
    fmt::print(stderr, "home {} of {}\n", seed, options.homes);
  }
  return recognition->finish();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Whether networks believe the furniture of made-up homes"};
  Options options;
  app.add_option("homes", options.homes, "How many; seeds from 1")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--rooms", options.rooms, "Of every home, separated by commas")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--models", options.models, "Folder of the networks; default: ROOMWISE_MODELS");
  app.add_option("--views", options.views, "Of a piece, at most")->capture_default_str();
  app.add_option("--bake-effort", options.bake_effort, "Rays of the light's bake; 1: as usual")
      ->capture_default_str();
  app.add_option("--light-cache", options.light_cache, "Folder that keeps the light between runs");
  app.add_option("--pictures", options.pictures,
                 "Folder for every view as a JPEG, and views.txt: what was said of each");
  CLI11_PARSE(app, argc, argv);
  if (const auto done = run(options); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
  return 0;
}
