#include "laboratory/training/processes.h"

#include <ATen/Functions.h>
#include <ATen/Parallel.h>
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>

#include "laboratory/training/batch_loader.h"
#include "laboratory/training/loss.h"
#include "laboratory/training/testing/small_data.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::training {
namespace {

using roomwise::testing::ScratchFolder;
using testing::small_options;
using testing::small_task;
using testing::SmallData;

constexpr const char* kOutput = "ROOMWISE_TEST_OUTPUT";
constexpr std::int64_t kAll = 8;  // pictures of a step of all processes

void write_floats(const std::filesystem::path& path, const std::vector<float>& values) {
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(values.data()),
                        values.size() * sizeof(float));
  ASSERT_OK(write_file(path, bytes));
}
std::vector<float> read_floats(const std::filesystem::path& path) {
  const auto bytes = read_file(path);
  if (!bytes) return {};
  std::vector<float> values(bytes->size() / sizeof(float));
  std::memcpy(values.data(), bytes->data(), bytes->size());
  return values;
}

// The gradients of a step on this process's part of eight pictures, averaged over all.
std::vector<float> gradients(Processes& processes) {
  const SmallData data(32);
  const TrainingTask task = small_task(data);
  const auto graph = TrainableGraph::create(task.graph);
  BatchLoaderOptions loading;
  loading.processes = processes.count();
  loading.rank = processes.rank();
  loading.batch = kAll / processes.count();
  BatchLoader loader(data, task.card, loading, 0);
  auto pictures = loader.next();
  const TensorBatch batch = tensors_of(pictures->pictures, pictures->labels, task.card, at::kCPU);
  // By the running statistics: those of a batch would differ from those of its halves.
  const auto outputs = graph->forward(batch.pictures, false);
  loss_of(*outputs, batch.labels, small_options(1)).backward();
  std::vector<at::Tensor> found;
  for (const GraphTensor& parameter : graph->parameters()) found.push_back(parameter.tensor.grad());
  EXPECT_OK(processes.average(found));
  std::vector<float> values;
  for (const at::Tensor& gradient : found) {
    const auto floats = constant_of(gradient).floats;
    values.insert(values.end(), floats.begin(), floats.end());
  }
  return values;
}

// The weights after some steps without batch normalisation.
std::vector<float> weights(Processes& processes) {
  const SmallData data(32), held_out(9, 8);
  TrainingTask task = small_task(data, false);
  task.held_out = &held_out;
  TrainingOptions options = small_options(6);
  options.batch = kAll / processes.count();
  SilentProgress silent;
  const auto result = train(task, options, processes, silent);
  EXPECT_OK(result);
  std::vector<float> values;
  for (const auto& [name, constant] : result->graph.constants)
    values.insert(values.end(), constant->floats.begin(), constant->floats.end());
  values.push_back(static_cast<float>(result->curve.back().held_out_cross_entropy));
  values.push_back(static_cast<float>(result->curve.back().held_out_precision));
  return values;
}

double relative_error(const std::vector<float>& values, const std::vector<float>& expected) {
  if (values.size() != expected.size() || expected.empty()) return 1;
  double largest = 0, difference = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double truth = static_cast<double>(expected[i]);
    largest = std::max(largest, std::abs(truth));
    difference = std::max(difference, std::abs(static_cast<double>(values[i]) - truth));
  }
  return difference / largest;
}

// A port of this machine that nobody listens on.
int free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  EXPECT_EQ(bind(socket, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size), 0);
  close(socket);
  return ntohs(address.sin_port);
}

// This test program again, as one of two processes.
pid_t start_worker(int rank, int port, const std::filesystem::path& output) {
  const pid_t child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // it would wait for the other long after this test's end
  setenv("MASTER_ADDR", "127.0.0.1", 1);
  setenv("MASTER_PORT", std::to_string(port).c_str(), 1);
  setenv("RANK", std::to_string(rank).c_str(), 1);
  setenv("WORLD_SIZE", "2", 1);
  setenv(kOutput, output.c_str(), 1);
  execl("/proc/self/exe", "training_test", "--gtest_filter=Processes.WorkTogether",
        static_cast<char*>(nullptr));
  _exit(127);
}

void work(const std::filesystem::path& output) {
  const auto place = ProcessPlace::from_environment();
  ASSERT_OK(place);
  const auto processes = Processes::join(**place, false);
  ASSERT_OK(processes);
  const auto told = (*processes)->broadcast((*place)->rank == 0 ? Bytes{1, 2, 3} : Bytes{});
  ASSERT_OK(told);
  EXPECT_EQ(*told, (Bytes{1, 2, 3}));
  write_floats(output / fmt::format("gradients{}", (*place)->rank), gradients(**processes));
  write_floats(output / fmt::format("weights{}", (*place)->rank), weights(**processes));
}

TEST(Processes, WorkTogether) {
  at::set_num_threads(1);
  if (const char* output = std::getenv(kOutput)) return work(output);
  const ScratchFolder folder;
  const int port = free_port();
  const pid_t workers[] = {start_worker(0, port, folder.path()),
                           start_worker(1, port, folder.path())};
  for (const pid_t worker : workers) {
    int status = -1;
    ASSERT_EQ(waitpid(worker, &status, 0), worker);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  }
  const auto of_one = alone();
  const std::vector<float> expected = gradients(*of_one), expected_weights = weights(*of_one);
  for (const char* rank : {"0", "1"}) {
    EXPECT_LT(relative_error(read_floats(folder / (std::string("gradients") + rank)), expected),
              1e-5);
    EXPECT_LT(
        relative_error(read_floats(folder / (std::string("weights") + rank)), expected_weights),
        1e-5);
  }
  EXPECT_EQ(read_floats(folder / "weights0"), read_floats(folder / "weights1"));
}

TEST(ProcessPlace, ComesFromTheEnvironment) {
  for (const char* variable : {"MASTER_ADDR", "MASTER_PORT", "RANK", "WORLD_SIZE"})
    unsetenv(variable);
  const auto none = ProcessPlace::from_environment();
  ASSERT_OK(none);
  EXPECT_FALSE(none->has_value());
  setenv("WORLD_SIZE", "2", 1);
  EXPECT_ERROR(ProcessPlace::from_environment(), "RANK is not set");
  setenv("RANK", "2", 1);
  EXPECT_ERROR(ProcessPlace::from_environment(), "RANK=2: expected a whole number from 0 to 1");
  setenv("RANK", "1", 1);
  setenv("MASTER_PORT", "29500", 1);
  EXPECT_ERROR(ProcessPlace::from_environment(), "MASTER_ADDR is not set");
  setenv("MASTER_ADDR", "computer", 1);
  const auto place = ProcessPlace::from_environment();
  ASSERT_OK(place);
  EXPECT_EQ((*place)->address, "computer");
  EXPECT_EQ((*place)->rank, 1);
  for (const char* variable : {"MASTER_ADDR", "MASTER_PORT", "RANK", "WORLD_SIZE"})
    unsetenv(variable);
}

TEST(UseGpu, SaysWhereThereIsNone) {
  ASSERT_OK(use_gpu(Device::kAuto));
  if (!*use_gpu(Device::kAuto)) EXPECT_ERROR(use_gpu(Device::kCuda), "no GPU that this libtorch");
  EXPECT_FALSE(*use_gpu(Device::kCpu));
}

}  // namespace
}  // namespace roomwise::training
