#pragma once

#include <functional>
#include <stdexcept>

#include "laboratory/training/head.h"
#include "laboratory/training/testing/small_networks.h"
#include "laboratory/training/trainer.h"
#include "roomwise/base/random.h"

// Pictures made in memory for tests of training, and small trainings.
namespace roomwise::training::testing {

// Noisy pictures of 16 x 16 pixels; each class has a colour of its own.
class SmallData final : public TrainingData {
 public:
  explicit SmallData(std::size_t size, std::uint64_t seed = 5) : size_(size), seed_(seed) {}

  [[nodiscard]] std::size_t size() const override { return size_; }
  [[nodiscard]] const std::vector<std::string>& classes() const override { return classes_; }
  [[nodiscard]] std::size_t label(std::size_t i) const override { return i % classes_.size(); }
  [[nodiscard]] std::string name(std::size_t i) const override {
    return fmt::format("{} of {}", i, seed_);
  }
  [[nodiscard]] Expected<image::ColorImage> picture(std::size_t i) const override {
    if (i == throwing) throw std::runtime_error("no memory for a picture");
    if (i == unreadable) return fail("picture {} is torn", i);
    RandomStream random(seed_, {i});
    image::ColorImage picture(16, 16);
    const std::size_t c = label(i);
    const auto value = [&](bool bright) {
      return static_cast<std::uint8_t>((bright ? 150 : 70) + random.index(60));
    };
    for (Rgb8& pixel : picture.pixels()) pixel = {value(c == 0), value(c == 1), value(c == 2)};
    return picture;
  }

  std::size_t unreadable = std::size_t(-1);
  std::size_t throwing = std::size_t(-1);

 private:
  std::size_t size_;
  std::uint64_t seed_;
  std::vector<std::string> classes_{"red", "green", "blue", "grey"};
};

inline network::ModelCard small_card() {
  network::ModelCard card;
  card.input_width_px = card.input_height_px = 16;
  card.mean = {127.5F, 127.5F, 127.5F};
  card.scale = {1 / 64.0F, 1 / 64.0F, 1 / 64.0F};
  return card;
}

inline TrainingTask small_task(const TrainingData& data, bool normalised = true) {
  auto head = with_new_head(small_network(normalised), "features", data.classes().size(), 1);
  TrainingTask task;
  task.graph = std::move(head->graph);
  task.logits = head->logits;
  task.card = small_card();
  task.training = &data;
  return task;
}

inline TrainingOptions small_options(std::int64_t steps) {
  TrainingOptions options;
  options.steps = steps;
  options.batch = 8;
  options.rate.base = 0.02;
  options.evaluate_every = 4;
  options.checkpoint_every = 3;
  options.device = Device::kCpu;
  return options;
}

// Calls `at_step` after every step.
class WatchedProgress final : public Progress {
 public:
  explicit WatchedProgress(std::function<void(std::uint64_t)> at_step)
      : at_step_(std::move(at_step)) {}
  void begin(std::string_view, std::optional<std::uint64_t>) override {}
  void advance(std::uint64_t done, std::string_view) override {
    done_ = done;
    at_step_(done);
  }
  void end() override {}
  [[nodiscard]] bool interrupted() const override { return done_ + 1 >= interrupt_in; }

  std::uint64_t interrupt_in = std::uint64_t(-1);  // this step is the last

 private:
  std::function<void(std::uint64_t)> at_step_;
  std::uint64_t done_ = 0;
};

}  // namespace roomwise::training::testing
