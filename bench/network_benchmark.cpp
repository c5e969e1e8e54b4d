// Runs the networks of ROOMWISE_MODELS by Roomwise and by OpenCV's DNN module on the photos of
// ROOMWISE_DATA/object_photos, on one thread on one processor, and prints what that costs; then in
// 8 bits (on these and some of room_photos), and by two threads that share a picture:
//   network_benchmark [ROUNDS]
// A round times each way in turn, so that a busy machine is unfair to neither.

#include <fmt/format.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <functional>

#include "arguments.h"
#include "fma_peak.h"
#include "resident_memory.h"
#include "roomwise/base/file.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/executor/checked_quantization.h"
#include "roomwise/network/formats/onnx_writer.h"
#include "roomwise/network/graph/inception_v3.h"
#include "roomwise/network/graph/lowering.h"
#include "roomwise/network/testing/opencv_network.h"
#include "roomwise/network/vision/picture_input.h"
#include "timing.h"

namespace {

using namespace roomwise;
using namespace roomwise::network;
namespace fs = std::filesystem;
using OpenCv = network::testing::OpenCvNetwork;
using bench::cpu_ms;
using bench::need;

constexpr std::size_t kPhotos = 40;
constexpr double kMinCpu_ms = 100;  // that one timing takes

struct Subject {
  std::string file;
  ModelCard card;  // how pictures are put in
  bool names_things = false;
  Bytes made = {};  // its bytes, where it is no file but a network of our own
};

// CPU-ms of one call.
double time_of(const std::function<void()>& call) {
  return bench::cpu_ms_of(call, kMinCpu_ms);
}

struct Summary {
  double median = 0, least = 0, most = 0;
};
Summary summary_of(std::vector<double> values) {
  std::ranges::sort(values);
  return {values[values.size() / 2], values.front(), values.back()};
}
std::string text_of(const Summary& summary) {
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", summary.median, summary.least, summary.most);
}

// Multiply-adds of the program's convolutions and products, times two.
double operations_of(const Program& program) {
  double operations = 0;
  for (const Layer& layer : program.layers) {
    const auto outputs = static_cast<double>(element_count(program.values[layer.output].shape));
    if (const auto* convolution = layer.as<Convolution>()) {
      const Constant& weights = *convolution->weights;
      operations += 2 * outputs * static_cast<double>(weights.floats.size()) /
                    static_cast<double>(weights.shape[0]);
    } else if (layer.as<MatrixProduct>() != nullptr) {
      operations += 2 * outputs * static_cast<double>(program.values[layer.inputs[0]].shape.back());
    }
  }
  return operations;
}

// What a child process that does nothing else needs until `first_result` returns.
struct StartUp {
  double cpu_ms = 0;
  double memory_mb = 0;
};
StartUp start_up(const std::function<void()>& first_result) {
  int ends[2];
  if (pipe(ends) != 0) std::abort();
  const pid_t child = fork();
  if (child == 0) {
    const double before_mb = bench::resident_mb(), before_ms = cpu_ms();
    first_result();
    const StartUp needed{cpu_ms() - before_ms, bench::resident_mb() - before_mb};
    if (write(ends[1], &needed, sizeof needed) != sizeof needed) std::_Exit(1);
    std::_Exit(0);
  }
  StartUp needed;
  if (child < 0 || read(ends[0], &needed, sizeof needed) != sizeof needed) std::abort();
  waitpid(child, nullptr, 0);
  close(ends[0]);
  close(ends[1]);
  return needed;
}

std::size_t best_of(const std::vector<float>& scores) {
  return static_cast<std::size_t>(std::ranges::max_element(scores) - scores.begin());
}

void compare_results(const Subject& subject, const Executor& ours, OpenCv& opencv,
                     const std::vector<Tensor>& inputs) {
  double error = 0;
  std::size_t same = 0;
  for (const Tensor& input : inputs) {
    const std::vector<float> values = need(ours.run({&input, 1})).front().values;
    const std::vector<float> expected = opencv.run(input);
    error = std::max(error, network::testing::relative_error(values, expected));
    same += best_of(values) == best_of(expected) ? 1 : 0;
  }
  fmt::print("  largest relative error on {} photos: {:.1e}\n", inputs.size(), error);
  if (subject.names_things) fmt::print("  same first label: {} of {}\n", same, inputs.size());
}

Tensor joined(std::span<const Tensor> pictures) {
  Tensor batch = pictures.front();
  batch.shape[0] = static_cast<std::int64_t>(pictures.size());
  for (const Tensor& picture : pictures.subspan(1))
    batch.values.insert(batch.values.end(), picture.values.begin(), picture.values.end());
  return batch;
}

Bytes bytes_of(const Subject& subject, const fs::path& models) {
  return subject.made.empty() ? need(read_file(models / subject.file)) : subject.made;
}

// Inception-v3 of our own with random weights. OpenCV counts the padding's zeros in means, as this
// network does, only in files that say that PyTorch wrote them; of two makers the last one counts.
Subject own_inception(const fs::path& models) {
  Subject subject{"Inception-v3 of our own, random weights", {}, true};
  subject.card = need(find_model_card(models / "inception_v3_google-0cc3c7bd.pth"));
  subject.made = need(write_onnx_graph(inception_v3()));
  constexpr std::string_view kMaker = "\x12\x07pytorch";
  subject.made.insert(subject.made.end(), kMaker.begin(), kMaker.end());
  return subject;
}

void hold_to_one_processor() {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  sched_setaffinity(0, sizeof one, &one);
}

// In 8 bits, measured on every fourth picture and checked on the others.
void calibrate_eight_bits(const Subject& subject, const fs::path& models,
                          std::span<const fs::path> pictures, int rounds) {
  const OnnxGraph graph = need(read_onnx_graph(bytes_of(subject, models)));
  ExecutorOptions in_floats;
  in_floats.outputs = subject.card.features_outputs;
  if (!subject.card.scores_output.empty()) in_floats.outputs.push_back(subject.card.scores_output);
  std::vector<Tensor> calibration, held_out;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    Tensor input = picture_input(need(image::read_color(pictures[i])), subject.card);
    (i % 4 == 0 ? calibration : held_out).push_back(std::move(input));
  }
  std::vector<std::size_t> scores;
  if (subject.names_things) scores.push_back(in_floats.outputs.size() - 1);
  // Whether it would be kept is asked first; what it costs, in any case.
  const CheckedExecutor checked =
      need(checked_quantization(graph, in_floats, calibration, held_out, scores));
  const QuantizationReport& report = checked.report;
  ExecutorOptions options = in_floats;
  options.eight_bits = need(calibrate_eight_bits(graph, in_floats, calibration));
  options.eight_bits->min_channels = report.min_channels;
  const auto exact = need(Executor::create(graph, in_floats));
  const auto rounded = need(Executor::create(graph, options));
  std::vector<double> exact_ms, rounded_ms, ratios;
  for (int round = 0; round < rounds; ++round) {
    exact_ms.push_back(time_of([&] { (void)need(exact->run(std::span(held_out).first(1))); }));
    rounded_ms.push_back(time_of([&] { (void)need(rounded->run(std::span(held_out).first(1))); }));
    ratios.push_back(rounded_ms.back() / exact_ms.back());
  }
  fmt::print("{}: in 8 bits from {} channels on ({} pictures to measure on, {} to check)\n",
             subject.file, report.min_channels, calibration.size(), held_out.size());
  fmt::print("  CPU-ms {} beside {}: {}\n", text_of(summary_of(rounded_ms)),
             text_of(summary_of(exact_ms)), text_of(summary_of(ratios)));
  for (std::size_t i = 0; i < in_floats.outputs.size(); ++i) {
    fmt::print("  {}: cosine {:.4f} in the mean, {:.4f} at worst; largest at one place {:.1f} %\n",
               in_floats.outputs[i], report.mean_cosine[i], report.min_cosine[i],
               100 * report.agreement[i]);
  }
  fmt::print("  {}\n", report.is_used ? "kept" : "not kept: " + report.reason);
}

// Wall time of one picture by one thread and by two that share it; means nothing on a busy machine,
// where threads that wait for each other do so for very long.
void measure_two_threads(const Subject& subject, const fs::path& models, int rounds) {
  const OnnxGraph graph = need(read_onnx_graph(bytes_of(subject, models)));
  const ModelCard& card = subject.card;
  Tensor input{{1, 3, card.input_height_px, card.input_width_px}, {}};
  input.values.resize(element_count(input.shape), 0.25F);
  ExecutorOptions options;
  const auto alone = need(Executor::create(graph, options));
  options.threads_per_input = 2;
  const auto together = need(Executor::create(graph, options));
  const auto wall_ms = [&](const Executor& executor) {
    const auto begin = std::chrono::steady_clock::now();
    (void)need(executor.run({&input, 1}));
    const std::chrono::duration<double, std::milli> taken =
        std::chrono::steady_clock::now() - begin;
    return taken.count();
  };
  std::vector<double> of_one, of_two;
  for (int call = 0; call < 5 * rounds; ++call) {
    of_one.push_back(wall_ms(*alone));
    of_two.push_back(wall_ms(*together));
  }
  const Summary one = summary_of(of_one), two = summary_of(of_two);
  fmt::print("{}: wall ms by one thread {}, by two {}; least / least {:.2f}, medians {:.2f}\n",
             subject.file, text_of(one), text_of(two), one.least / two.least,
             one.median / two.median);
}

// Before anything else, since memory that was used once counts as a child's from its beginning.
void measure_start(const Subject& subject, const fs::path& models, int rounds) {
  const auto side = [](int pixels) { return static_cast<std::size_t>(pixels); };
  const ModelCard& card = subject.card;
  const Tensor input{
      {1, 3, card.input_height_px, card.input_width_px},
      std::vector<float>(3 * side(card.input_height_px) * side(card.input_width_px))};
  fmt::print("{}: from the file to the first result\n", subject.file);
  const auto start = [&](const char* name, const std::function<void(const Bytes&)>& run) {
    std::vector<double> cpu, memory;
    for (int round = 0; round < rounds; ++round) {
      const StartUp needed = start_up([&] { run(need(read_file(models / subject.file))); });
      cpu.push_back(needed.cpu_ms);
      memory.push_back(needed.memory_mb);
    }
    fmt::print("  {}: CPU-ms {}, memory {:.0f} MB\n", name, text_of(summary_of(cpu)),
               summary_of(memory).median);
  };
  std::unique_ptr<Executor> executor;
  start("Roomwise", [&](const Bytes& bytes) {
    executor = need(Executor::create(need(read_onnx_graph(bytes))));
    (void)need(executor->run({&input, 1}));
  });
  std::unique_ptr<OpenCv> opencv;
  start("OpenCV", [&](const Bytes& bytes) {
    opencv = std::make_unique<OpenCv>(bytes);
    (void)opencv->run(input);
  });
}

void measure(const Subject& subject, const fs::path& models, std::span<const fs::path> photos,
             int rounds) {
  const Bytes bytes = bytes_of(subject, models);
  std::vector<Tensor> inputs;
  for (const fs::path& photo : photos)
    inputs.push_back(picture_input(need(image::read_color(photo)), subject.card));
  fmt::print("{}\n", subject.file);
  const OnnxGraph graph = need(read_onnx_graph(bytes));
  const std::vector<Shape> shapes{inputs.front().shape};
  const Program written = need(lower(graph, shapes, {}));
  const double work = operations_of(written), our_work = operations_of(run_passes(written, {}));
  const auto executor = need(Executor::create(graph));
  OpenCv opencv(bytes);
  compare_results(subject, *executor, opencv, inputs);

  std::vector<double> ours, pairs, theirs, their_pairs, ratios, peaks;
  const std::span<const Tensor> pair = std::span(inputs).first(2);
  const Tensor batch = joined(pair);
  OpenCv opencv_pair(bytes);
  bool opencv_takes_pairs = true;
  for (int round = 0; round < rounds; ++round) {
    ours.push_back(time_of([&] { (void)need(executor->run({inputs.data(), 1})); }));
    theirs.push_back(time_of([&] { (void)opencv.run(inputs.front()); }));
    ratios.push_back(ours.back() / theirs.back());
    pairs.push_back(time_of([&] { (void)need(executor->run_batch(pair, 1)); }) / 2);
    try {
      if (opencv_takes_pairs)
        their_pairs.push_back(time_of([&] { (void)opencv_pair.run(batch); }) / 2);
    } catch (const cv::Exception&) {
      opencv_takes_pairs = false;  // a network whose file fixes the batch
    }
    peaks.push_back(bench::fma_peak_gflops());
  }
  const double peak = summary_of(peaks).median;
  const auto share = [&](double operations, const Summary& time_ms) {
    return 100 * operations / (time_ms.median * 1e6) / peak;
  };
  fmt::print("  {:.2f} GFLOP as written, {:.2f} after the passes; peak {:.0f} GFLOP/s ({})\n",
             work / 1e9, our_work / 1e9, peak, bench::fma_peak_instructions());
  fmt::print("  Roomwise: CPU-ms {}, {:.0f} % of the peak; of two, each {}\n",
             text_of(summary_of(ours)), share(our_work, summary_of(ours)),
             text_of(summary_of(pairs)));
  fmt::print("  OpenCV:   CPU-ms {}, {:.0f} % of the peak; of two, each {}\n",
             text_of(summary_of(theirs)), share(work, summary_of(theirs)),
             opencv_takes_pairs ? text_of(summary_of(their_pairs)) : "-");
  fmt::print("  Roomwise / OpenCV: {}\n", text_of(summary_of(ratios)));
}

fs::path folder_of(const char* variable) {
  const char* folder = std::getenv(variable);
  if (folder == nullptr) {
    fmt::print(stderr, "set {} to the folder of real data or networks\n", variable);
    std::exit(1);
  }
  return folder;
}

std::vector<fs::path> every_second_of(const fs::path& folder) {
  std::vector<fs::path> photos, some;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".jpg") photos.push_back(entry.path());
  }
  std::ranges::sort(photos);
  for (std::size_t i = 0; i < photos.size(); i += 2) some.push_back(photos[i]);
  return some;
}

}  // namespace

int main(int argc, char** argv) {
  const auto given = bench::only_count(argc, argv, 9, "network_benchmark [ROUNDS]");
  if (!given) {
    fmt::print(stderr, "{}\n", given.error().message);
    return 2;
  }
  const int rounds = *given;
  cpu_set_t all;
  sched_getaffinity(0, sizeof all, &all);
  hold_to_one_processor();

  const fs::path models = folder_of("ROOMWISE_MODELS");
  std::vector<fs::path> photos;
  for (const auto& entry : fs::directory_iterator(folder_of("ROOMWISE_DATA") / "object_photos"))
    photos.push_back(entry.path());
  std::ranges::sort(photos);
  photos.resize(std::min(photos.size(), kPhotos));

  Subject mobilenet{"mobilenet-v2-imagenet.onnx", {}, true};
  mobilenet.card = need(find_model_card(models / mobilenet.file));
  Subject inception{"inception-2015-12-05-trunk.onnx", {}, false};
  inception.card = need(find_model_card(models / inception.file));
  Subject nanodet{"nanodet-plus-m-416.onnx", {}, false};
  nanodet.card = need(find_model_card(models / nanodet.file));
  const std::array subjects{mobilenet, nanodet, inception};
  for (const Subject& subject : subjects) measure_start(subject, models, rounds);
  for (const Subject& subject : subjects) measure(subject, models, photos, rounds);
  const Subject own = own_inception(models);
  measure(own, models, photos, rounds);

  std::vector<fs::path> pictures = photos;
  for (const fs::path& photo : every_second_of(folder_of("ROOMWISE_DATA") / "room_photos"))
    pictures.push_back(photo);
  for (const Subject& subject : {mobilenet, inception, own})
    calibrate_eight_bits(subject, models, pictures, rounds);
  sched_setaffinity(0, sizeof all, &all);
  for (const Subject& subject : {mobilenet, nanodet, inception, own})
    measure_two_threads(subject, models, rounds);
  return 0;
}
