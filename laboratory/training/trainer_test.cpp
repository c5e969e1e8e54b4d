#include "laboratory/training/trainer.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>

#include "laboratory/training/processes.h"
#include "laboratory/training/testing/small_data.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/network/executor/executor.h"
#include "roomwise/network/formats/onnx_writer.h"
#include "roomwise/network/vision/picture_input.h"

namespace roomwise::training {
namespace {

using roomwise::testing::ScratchFolder;
using testing::small_options;
using testing::small_task;
using testing::SmallData;
using testing::WatchedProgress;

Expected<TrainingResult> train_alone(const TrainingTask& task, const TrainingOptions& options) {
  SilentProgress silent;
  return train(task, options, *alone(), silent);
}

// Everything random and everything that has a state.
TrainingOptions restless_options() {
  TrainingOptions options = small_options(17);
  options.optimizer = Optimizer::kAdam;
  options.rate.base = 0.003;
  options.rate.warm_up_steps = 5;
  options.augmentation = network::AugmentationOptions{};
  options.seed = 3;
  return options;
}

void expect_same_weights(const network::OnnxGraph& a, const network::OnnxGraph& b) {
  ASSERT_EQ(a.constants.size(), b.constants.size());
  for (const auto& [name, constant] : a.constants)
    EXPECT_EQ(constant->floats, b.constants.at(name)->floats) << name;
}

TEST(Train, LearnsFewPicturesByHeart) {
  const SmallData data(64);
  TrainingTask task = small_task(data);
  task.held_out = &data;
  TrainingOptions options = small_options(120);
  options.optimizer = Optimizer::kAdam;
  options.label_smoothing = 0;
  options.evaluate_every = 40;
  const auto result = train_alone(task, options);
  ASSERT_OK(result);
  ASSERT_EQ(result->curve.size(), 3);
  EXPECT_TRUE(result->finished);
  EXPECT_LT(result->curve.back().held_out_cross_entropy, 0.05);
  EXPECT_EQ(result->curve.back().held_out_precision, 1);
  EXPECT_LT(result->curve.back().cross_entropy, result->curve.front().cross_entropy / 4);

  // The file that is written of it says the same of every picture.
  const auto onnx = network::write_onnx_graph(result->graph);
  ASSERT_OK(onnx);
  const auto graph = network::read_onnx_graph(*onnx);
  ASSERT_OK(graph);
  const auto executor = network::Executor::create(*graph);
  ASSERT_OK(executor);
  for (std::size_t i = 0; i < data.size(); ++i) {
    const network::Tensor input = network::picture_input(*data.picture(i), task.card);
    const auto outputs = (*executor)->run({&input, 1});
    ASSERT_OK(outputs);
    const auto& scores = outputs->front().values;
    EXPECT_EQ(std::ranges::max_element(scores) - scores.begin(),
              static_cast<std::ptrdiff_t>(data.label(i)));
  }
}

TEST(Train, GoesOnAfterAKillAsIfNothingHadBeen) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const SmallData data(20), held_out(8, 6);
  TrainingTask task = small_task(data);
  task.held_out = &held_out;
  TrainingOptions options = restless_options();
  const auto whole = train_alone(task, options);
  ASSERT_OK(whole);

  // The process that is killed is this test, run anew up to here: it is told where to write.
  const ScratchFolder folder;
  setenv("ROOMWISE_TEST_CHECKPOINT", (folder / "checkpoint").c_str(), /*overwrite=*/0);
  options.checkpoint = std::getenv("ROOMWISE_TEST_CHECKPOINT");
  const std::uint64_t killed_at = 4 + RandomStream(11).index(12);
  EXPECT_EXIT(
      {
        WatchedProgress killer([&](std::uint64_t step) {
          if (step == killed_at) raise(SIGKILL);
        });
        (void)train(task, options, *alone(), killer);
      },
      ::testing::KilledBySignal(SIGKILL), "");
  unsetenv("ROOMWISE_TEST_CHECKPOINT");
  options.resume = true;
  options.loader_threads = 3;
  const auto resumed = train_alone(task, options);
  ASSERT_OK(resumed);
  expect_same_weights(whole->graph, resumed->graph);
  EXPECT_EQ(whole->curve, resumed->curve);
  EXPECT_EQ(whole->best_step, resumed->best_step);
}

TEST(Train, EndsWhenInterruptedAndGoesOn) {
  const SmallData data(20), held_out(8, 6);
  TrainingTask task = small_task(data);
  task.held_out = &held_out;
  TrainingOptions options = restless_options();
  options.optimizer = Optimizer::kRmsProp;
  const auto whole = train_alone(task, options);
  ASSERT_OK(whole);
  const ScratchFolder folder;
  options.checkpoint = folder / "checkpoint";
  WatchedProgress progress([](std::uint64_t) {});
  progress.interrupt_in = 7;
  const auto part = train(task, options, *alone(), progress);
  ASSERT_OK(part);
  EXPECT_FALSE(part->finished);
  EXPECT_EQ(part->steps, 7);
  options.resume = true;
  const auto resumed = train_alone(task, options);
  ASSERT_OK(resumed);
  EXPECT_TRUE(resumed->finished);
  expect_same_weights(whole->graph, resumed->graph);
  EXPECT_EQ(whole->curve, resumed->curve);

  // A checkpoint of other options, and half of one.
  options.rate.base *= 2;
  EXPECT_ERROR(train_alone(task, options), "is of another training: \"learning rate 0.003 ");
  options.rate.base /= 2;
  // As many other pictures, and pictures put in otherwise.
  const SmallData other_data(20, 99);
  TrainingTask other = task;
  other.training = &other_data;
  EXPECT_ERROR(train_alone(other, options), "is of another training: \"pictures 20 ");
  other = task;
  other.held_out = &other_data;
  EXPECT_ERROR(train_alone(other, options), "is of another training: \"held out 8 ");
  other = task;
  other.card.scale[1] *= 2;
  EXPECT_ERROR(train_alone(other, options), "is of another training: \"input 16 x 16 ");
  Bytes bytes = *read_file(options.checkpoint);
  bytes.resize(bytes.size() / 2);
  ASSERT_OK(write_file(options.checkpoint, bytes));
  EXPECT_ERROR(train_alone(task, options), "damaged");
}

TEST(Train, LeavesFrozenLayersAsTheyAre) {
  const SmallData data(16);
  const TrainingTask task = small_task(data);
  TrainingOptions options = small_options(5);
  options.from = "second";
  const auto result = train_alone(task, options);
  ASSERT_OK(result);
  for (const auto& [name, constant] : task.graph.constants) {
    const bool same = constant->floats == result->graph.constants.at(name)->floats;
    // A bias before batch normalisation changes nothing, and so does not change.
    EXPECT_EQ(same, name.starts_with("first") || name == "second_bias") << name;
  }
}

TEST(Train, KeepsTheBestStep) {
  const SmallData data(16), held_out(12, 9);
  TrainingTask task = small_task(data);
  task.held_out = &held_out;
  TrainingOptions options = small_options(24);
  options.rate.base = 0.3;  // too large, so that it goes up and down
  options.rate.schedule = LearningRate::Schedule::kConstant;
  options.evaluate_every = 2;
  const auto result = train_alone(task, options);
  ASSERT_OK(result);
  const auto best = std::ranges::max_element(result->curve, {}, [](const CurvePoint& point) {
    return std::pair(point.held_out_precision, -point.held_out_cross_entropy);
  });
  EXPECT_EQ(result->best_step, best->step);
  // A training that ends there gives the same weights.
  options.steps = result->best_step;
  const auto shorter = train_alone(task, options);
  ASSERT_OK(shorter);
  ASSERT_EQ(shorter->best_step, result->best_step);
  expect_same_weights(shorter->graph, result->graph);
}

TEST(Train, LearnsBySecondHeadsToo) {
  const SmallData data(16);
  network::OnnxGraph graph = testing::small_network();
  graph.constants["aux.weight"] = testing::random_constant({7, 8}, 0.1, 0, 3);
  graph.nodes.push_back(testing::node("GlobalAveragePool", {"first"}, "aux_pool"));
  graph.nodes.push_back(testing::node("Flatten", {"aux_pool"}, "aux_features"));
  graph.nodes.push_back(testing::node("Gemm", {"aux_features", "aux.weight"}, "aux"));
  graph.nodes.back().attributes["transB"] = network::Attribute(std::int64_t{1});
  graph.outputs.push_back("aux");
  const auto head = with_new_head(graph, "features", 4, 1);
  ASSERT_OK(head);
  EXPECT_EQ(head->aux_logits, "aux_logits");
  TrainingTask task = small_task(data);
  task.graph = head->graph;
  task.logits = head->logits;
  const auto without = train_alone(task, small_options(2));
  task.aux_logits = head->aux_logits;
  const auto with = train_alone(task, small_options(2));
  ASSERT_OK(without);
  ASSERT_OK(with);
  EXPECT_GT(with->curve.front().cross_entropy, 1.3 * without->curve.front().cross_entropy);
  EXPECT_NE(with->graph.constants.at("first_weights")->floats,
            without->graph.constants.at("first_weights")->floats);
  EXPECT_EQ(with->graph.outputs, std::vector<std::string>{"logits"});
  EXPECT_FALSE(with->graph.constants.contains("aux_logits.weight"));
}

// One of two processes, of which the other says what this one says, or what it is given.
class OneOfTwo final : public Processes {
 public:
  explicit OneOfTwo(int rank, Bytes first = {}) : first_(std::move(first)), rank_(rank) {}
  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int count() const override { return 2; }
  [[nodiscard]] Expected<void> average(std::span<const at::Tensor>) override { return {}; }
  [[nodiscard]] Expected<Bytes> broadcast(Bytes bytes) override {
    if (rank_ == 0) first_ = std::move(bytes);
    return first_;
  }
  [[nodiscard]] const Bytes& first() const { return first_; }

 private:
  Bytes first_;
  int rank_;
};

TEST(Train, IsTheSameInAllProcesses) {
  const SmallData data(20), other_data(20, 6);
  TrainingTask task = small_task(data);
  TrainingOptions options = small_options(1);
  SilentProgress silent;
  OneOfTwo rank_0(0);
  ASSERT_OK(train(task, options, rank_0, silent));
  OneOfTwo rank_1(1, rank_0.first());
  options.threads = 2;  // each as its machine has
  EXPECT_OK(train(task, options, rank_1, silent));
  options.seed = 9;
  EXPECT_ERROR(train(task, options, rank_1, silent), "\"seed 0\", not \"seed 9\"");
  options.seed = 0;
  task.training = &other_data;
  EXPECT_ERROR(train(task, options, rank_1, silent), "rank 1: \"pictures 20 ");
}

TEST(Train, SaysWhatIsWrong) {
  SmallData data(16);
  TrainingTask task = small_task(data);
  TrainingOptions options = small_options(3);
  options.momentum = 1;
  EXPECT_ERROR(train_alone(task, options), "momentum is 1; expected a number from 0 to 0.9999");
  options = small_options(0);
  EXPECT_ERROR(train_alone(task, options), "steps is 0; expected at least 1");
  options = small_options(3);
  options.from = "third";
  EXPECT_ERROR(train_alone(task, options), "no node or block \"third\"");
  options = small_options(50);
  options.rate.base = 1e3;
  options.rate.schedule = LearningRate::Schedule::kConstant;
  options.weight_decay = 1;  // weights grow a thousandfold each step
  EXPECT_ERROR(train_alone(task, options), "try a lower learning rate");
  options = small_options(3);
  data.unreadable = 5;
  EXPECT_ERROR(train_alone(task, options), "picture 5 is torn");
  data.throwing = 5;
  EXPECT_ERROR(train_alone(task, options), "the training failed: no memory for a picture");
  const SmallData nothing(0);
  task.training = &nothing;
  EXPECT_ERROR(train_alone(task, options), "no pictures");
  EXPECT_ERROR(with_new_head(testing::small_network(), "pool5", 4, 1), "\"pool5\"");
}

}  // namespace
}  // namespace roomwise::training
