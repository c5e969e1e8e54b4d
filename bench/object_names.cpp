// How rightly networks name furniture of homes that they were not trained on (the models of
// furniture are the same): pictures of `roomwise simulate-views` and photos of ImageNet's classes,
// by kind:
//   object_names VIEWS [NETWORK]...
// VIEWS: the folder of simulated views. Networks: ONNX files with their cards; default: the compact
// network of models/ and MobileNetV2 of ROOMWISE_MODELS. The photos are those of ROOMWISE_DATA/
// object_photos (nNUMBER_CLASS.jpg), if there are any.
// Same figures on every run; the times are of one thread.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <opencv2/core/utility.hpp>

#include "roomwise/evaluation/statistics/proportion.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "roomwise/objects/detection/object_vocabulary.h"
#include "timing.h"

namespace {

using namespace roomwise;
namespace fs = std::filesystem;
using bench::need;
using evaluation::Proportion;

// A kind of furniture by its own name; ImageNet's labels that mean it, and its classes by the names
// of the photos' files.
struct Kind {
  std::string_view name;
  std::vector<std::string_view> labels = {};
  std::vector<std::string_view> photos = {};
};

const std::array kKinds{
    Kind{"armchair"},
    Kind{"bathtub", {"bathtub", "tub"}, {"bathtub", "tub"}},
    Kind{"bed", {"four-poster", "studio couch", "quilt", "pillow"}, {"four-poster"}},
    Kind{"bookcase", {"bookcase"}, {"bookcase"}},
    Kind{"chair", {"folding chair", "rocking chair"}, {"folding_chair", "rocking_chair"}},
    Kind{"chest of drawers", {"chiffonier"}, {"chiffonier"}},
    Kind{"coffee table"},
    Kind{"computer", {"desktop computer", "monitor", "screen"}, {"desktop_computer"}},
    Kind{"desk", {"desk"}, {"desk"}},
    Kind{"dining table", {"dining table"}, {"dining_table"}},
    Kind{"fridge", {"refrigerator"}, {"refrigerator"}},
    Kind{"kitchen sink"},
    Kind{"lamp", {"table lamp", "lampshade"}, {"table_lamp", "lampshade"}},
    Kind{"microwave", {"microwave"}, {"microwave"}},
    Kind{"nightstand"},
    Kind{"office chair"},
    Kind{"plant", {"pot"}},
    Kind{"radiator", {"radiator"}, {"radiator"}},
    Kind{"shower", {"shower curtain"}, {"shower_curtain"}},
    Kind{"sofa", {"studio couch"}, {"studio_couch"}},
    Kind{"stove", {"stove", "microwave", "rotisserie"}, {"stove"}},
    Kind{"television", {"television", "monitor", "screen"}, {"television"}},
    Kind{"toilet", {"toilet seat"}, {"toilet_seat"}},
    Kind{"wardrobe",
         {"wardrobe", "chiffonier", "china cabinet", "sliding door", "medicine chest"},
         {"wardrobe"}},
    Kind{"washbasin", {"washbasin"}, {"washbasin"}},
};
constexpr std::string_view kRoom = "room: ";

struct Picture {
  std::string shows;  // a kind or "room: ..."
  fs::path file;
};

std::vector<fs::path> sorted_entries(const fs::path& folder) {
  std::vector<fs::path> entries;
  for (const auto& entry : fs::directory_iterator(folder)) entries.push_back(entry.path());
  std::ranges::sort(entries);
  return entries;
}

std::vector<Picture> pictures_of_views(const fs::path& folder) {
  std::vector<Picture> pictures;
  for (const fs::path& of_class : sorted_entries(folder)) {
    if (!fs::is_directory(of_class)) continue;
    for (const fs::path& file : sorted_entries(of_class)) {
      pictures.push_back({of_class.filename().string(), file});
    }
  }
  return pictures;
}

std::vector<Picture> pictures_of_photos(const fs::path& folder) {
  std::vector<Picture> pictures;
  for (const fs::path& file : sorted_entries(folder)) {
    const std::string stem = file.stem().string();
    const std::string shown = stem.substr(std::min(stem.find('_'), stem.size() - 1) + 1);
    for (const Kind& kind : kKinds) {
      if (std::ranges::find(kind.photos, shown) != kind.photos.end())
        pictures.push_back({std::string(kind.name), file});
    }
  }
  return pictures;
}

struct Tally {
  Proportion first, three, among_furniture;
};

class Judge {
 public:
  explicit Judge(const fs::path& file) : network_(need(network::OnnxClassifier::load(file))) {
    const auto is_room = [](const std::string& label) { return label.starts_with(kRoom); };
    knows_rooms_ = std::ranges::any_of(network_->labels(), is_room);
  }

  [[nodiscard]] const std::string& name() const { return network_->name(); }
  // Whether it has a label for what is shown.
  [[nodiscard]] bool knows(const std::string& shows) const {
    return std::ranges::any_of(network_->labels(),
                               [&](const std::string& label) { return means(label, shows); });
  }

  void look(const std::vector<Picture>& pictures, std::map<std::string, Tally>& tallies) {
    for (const Picture& picture : pictures) {
      if (!knows(picture.shows)) continue;
      const image::ColorImage image = need(image::read_color(picture.file));
      const double begin = bench::cpu_ms();
      const network::Prediction seen = need(network_->predict(image));
      if (looked_ > 0) ms_ += bench::cpu_ms() - begin;  // the first one makes the plan
      ++looked_;
      count(picture.shows, seen.scores, tallies[picture.shows]);
    }
  }
  [[nodiscard]] double ms_per_picture() const {
    return ms_ / static_cast<double>(std::max<std::uint64_t>(looked_, 2) - 1);
  }

 private:
  [[nodiscard]] static bool means(const std::string& label, const std::string& shows) {
    if (objects::same_label(label, shows)) return true;
    const auto kind = std::ranges::find(kKinds, shows, &Kind::name);
    return kind != kKinds.end() && std::ranges::any_of(kind->labels, [&](std::string_view known) {
             return objects::same_label(label, known);
           });
  }

  void count(const std::string& shows, std::span<const float> scores, Tally& tally) const {
    const auto& labels = network_->labels();
    std::vector<std::size_t> order(scores.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::ranges::stable_sort(order, std::greater{}, [&](std::size_t i) { return scores[i]; });
    const auto is_right = [&](std::size_t i) { return means(labels[i], shows); };
    constexpr std::size_t kFew = 3;
    tally.first.add(is_right(order.front()));
    tally.three.add(
        std::ranges::any_of(std::span(order).first(std::min(kFew, order.size())), is_right));
    if (shows.starts_with(kRoom) || !knows_rooms_) return;
    const auto best =
        std::ranges::find_if(order, [&](std::size_t i) { return !labels[i].starts_with(kRoom); });
    tally.among_furniture.add(is_right(*best));
  }

  std::unique_ptr<network::OnnxClassifier> network_;
  bool knows_rooms_ = false;
  double ms_ = 0;
  std::uint64_t looked_ = 0;
};

std::string percent(const Proportion& proportion) {
  return proportion.n == 0 ? "-" : fmt::format("{:.0f}", 100 * proportion.value());
}

std::string columns(const Tally& tally) {
  return fmt::format("{} / {} / {}", percent(tally.first), percent(tally.three),
                     percent(tally.among_furniture));
}

// Of all pictures of furniture, or of rooms, together.
Tally sum_of(const std::map<std::string, Tally>& tallies, bool of_rooms) {
  Tally sum;
  const auto add = [](Proportion& to, const Proportion& part) {
    to.successes += part.successes;
    to.n += part.n;
  };
  for (const auto& [shows, tally] : tallies) {
    if (shows.starts_with(kRoom) != of_rooms) continue;
    add(sum.first, tally.first);
    add(sum.three, tally.three);
    add(sum.among_furniture, tally.among_furniture);
  }
  return sum;
}

void print_table(const std::string& title, const std::vector<Picture>& pictures,
                 std::vector<Judge>& judges) {
  std::vector<std::map<std::string, Tally>> tallies(judges.size());
  for (std::size_t i = 0; i < judges.size(); ++i) judges[i].look(pictures, tallies[i]);
  std::map<std::string, std::size_t> counts;
  for (const Picture& picture : pictures) ++counts[picture.shows];
  fmt::print("{}: top-1 / top-3 / top-1 among furniture alone, %\n\n| shows | pictures |", title);
  for (const Judge& judge : judges) fmt::print(" {} |", judge.name());
  fmt::print("\n| --- | --- |{}\n", [&] {
    std::string line;
    for (std::size_t i = 0; i < judges.size(); ++i) line += " --- |";
    return line;
  }());
  for (const auto& [shows, number] : counts) {
    fmt::print("| {} | {} |", shows, number);
    for (const auto& of_network : tallies) {
      const auto found = of_network.find(shows);
      fmt::print(" {} |", found == of_network.end() ? "no such label" : columns(found->second));
    }
    fmt::print("\n");
  }
  for (const bool of_rooms : {false, true}) {
    fmt::print("| all {} | |", of_rooms ? "rooms" : "furniture");
    for (const auto& of_network : tallies) {
      const Tally sum = sum_of(of_network, of_rooms);
      fmt::print(" {} of {} |", columns(sum), sum.first.n);
    }
    fmt::print("\n");
  }
  fmt::print("\n");
}

fs::path folder_of(const char* variable) {
  const char* value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || !fs::is_directory(argv[1])) {
    fmt::print(stderr,
               "usage: object_names VIEWS [NETWORK]...; VIEWS: a folder that roomwise "
               "simulate-views wrote\n");
    return 2;
  }
  cv::setNumThreads(1);
  std::vector<Judge> judges;
  for (int i = 2; i < argc; ++i) judges.emplace_back(argv[i]);
  if (judges.empty()) {
    judges.emplace_back(fs::path(ROOMWISE_OWN_NETWORKS) / "roomwise-compact-2.onnx");
    const fs::path models = folder_of("ROOMWISE_MODELS");
    if (!models.empty()) judges.emplace_back(models / "mobilenet-v2-imagenet.onnx");
  }
  print_table("Simulated views", pictures_of_views(argv[1]), judges);
  const fs::path photos = folder_of("ROOMWISE_DATA") / "object_photos";
  if (fs::is_directory(photos)) print_table("Photos", pictures_of_photos(photos), judges);
  for (const Judge& judge : judges) {
    fmt::print("{}: {:.1f} CPU-ms a picture\n", judge.name(), judge.ms_per_picture());
  }
  return 0;
}
