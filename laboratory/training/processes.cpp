#include "laboratory/training/processes.h"

#include <ATen/Functions.h>
#include <ATen/core/grad_mode.h>
#include <torch/version.h>

#include <charconv>
#include <chrono>
#include <cstdlib>
#include <torch/csrc/distributed/c10d/TCPStore.hpp>
#ifdef USE_C10D_GLOO
#include <torch/csrc/distributed/c10d/ProcessGroupGloo.hpp>
#endif
#ifdef USE_C10D_NCCL
#include <torch/csrc/distributed/c10d/ProcessGroupNCCL.hpp>
#endif

#include "laboratory/training/trainable_graph.h"

namespace roomwise::training {
namespace {

// What Gloo and NCCL are to c10d.
#if TORCH_VERSION_MAJOR >= 2
using Collectives = c10d::Backend;
#else
using Collectives = c10d::ProcessGroup;
#endif

class Alone final : public Processes {
 public:
  [[nodiscard]] int rank() const override { return 0; }
  [[nodiscard]] int count() const override { return 1; }
  [[nodiscard]] Expected<void> average(std::span<const at::Tensor>) override { return {}; }
  [[nodiscard]] Expected<Bytes> broadcast(Bytes bytes) override { return bytes; }
};

class Group final : public Processes {
 public:
  Group(const ProcessPlace& place, c10::intrusive_ptr<Collectives> group, bool on_gpu)
      : place_(place), group_(std::move(group)), on_gpu_(on_gpu) {}

  [[nodiscard]] int rank() const override { return place_.rank; }
  [[nodiscard]] int count() const override { return place_.count; }

  [[nodiscard]] Expected<void> average(std::span<const at::Tensor> tensors) override {
    if (tensors.empty()) return {};
    const at::NoGradGuard no_gradient;
    return in_group([&] {
      // One message for all: many small ones would wait for each other.
      std::vector<at::Tensor> flat;
      for (const at::Tensor& tensor : tensors) flat.push_back(tensor.flatten().to(at::kFloat));
      std::vector<at::Tensor> joined{at::cat(flat)};
      group_->allreduce(joined)->wait();
      joined.front().div_(place_.count);
      std::int64_t begin = 0;
      for (at::Tensor tensor : tensors) {
        tensor.copy_(joined.front().slice(0, begin, begin + tensor.numel()).view(tensor.sizes()));
        begin += tensor.numel();
      }
    });
  }

  [[nodiscard]] Expected<Bytes> broadcast(Bytes bytes) override {
    const auto device = at::Device(on_gpu_ ? at::kCUDA : at::kCPU);
    ROOMWISE_RETURN_IF_ERROR(in_group([&] {
      std::vector<at::Tensor> size{at::full({1}, std::ssize(bytes), at::kLong).to(device)};
      group_->broadcast(size)->wait();
      bytes.resize(static_cast<std::size_t>(size.front().item<std::int64_t>()));
      if (bytes.empty()) return;
      const at::Tensor ours = at::from_blob(bytes.data(), {std::ssize(bytes)}, at::kByte);
      std::vector<at::Tensor> content{ours.to(device)};
      group_->broadcast(content)->wait();
      ours.copy_(content.front());
    }));
    return bytes;
  }

 private:
  template <typename Call>
  Expected<void> in_group(const Call& call) {
    try {
      call();
    } catch (const std::exception& error) {  // c10d's
      return fail("process {} of {} lost the others: {}", place_.rank, place_.count,
                  first_line(error));
    }
    return {};
  }

  ProcessPlace place_;
  c10::intrusive_ptr<Collectives> group_;
  bool on_gpu_;
};

#ifdef USE_C10D_GLOO
c10::intrusive_ptr<Collectives> gloo_group(const c10::intrusive_ptr<c10d::Store>& store,
                                           const ProcessPlace& place) {
  auto options = c10d::ProcessGroupGloo::Options::create();
  const char* interface = std::getenv("GLOO_SOCKET_IFNAME");
  const bool local = place.address == "localhost" || place.address.starts_with("127.");
  if (interface != nullptr) {
    options->devices = {c10d::ProcessGroupGloo::createDeviceForInterface(interface)};
  } else if (local) {
    options->devices = {c10d::ProcessGroupGloo::createDeviceForHostname(place.address)};
  } else {
    options->devices = {c10d::ProcessGroupGloo::createDefaultDevice()};
  }
  options->threads = 1;
  return c10::make_intrusive<c10d::ProcessGroupGloo>(store, place.rank, place.count, options);
}
#endif

c10::intrusive_ptr<Collectives> make_group(const c10::intrusive_ptr<c10d::Store>& store,
                                           const ProcessPlace& place, bool on_gpu) {
#ifdef USE_C10D_NCCL
  if (on_gpu) return c10::make_intrusive<c10d::ProcessGroupNCCL>(store, place.rank, place.count);
#else
  TORCH_CHECK(!on_gpu, "this libtorch has no NCCL, by which GPUs talk; give --device cpu");
#endif
#ifdef USE_C10D_GLOO
  return gloo_group(store, place);
#else
  TORCH_CHECK(false, "this libtorch has no Gloo, by which processors talk; give --device cuda");
#endif
}

Expected<int> number_from(const char* variable, int least, int most) {
  const char* text = std::getenv(variable);
  if (text == nullptr) {
    return fail(
        "{} is not set; training by several processes needs MASTER_ADDR, MASTER_PORT, RANK and "
        "WORLD_SIZE",
        variable);
  }
  const std::string_view digits = text;
  int number = 0;
  const char* const end = digits.data() + digits.size();
  const auto [parsed, error] = std::from_chars(digits.data(), end, number);
  if (error != std::errc() || parsed != end || number < least || number > most)
    return fail("{}={}: expected a whole number from {} to {}", variable, text, least, most);
  return number;
}

}  // namespace

Expected<std::optional<ProcessPlace>> ProcessPlace::from_environment() {
  bool any = false;
  for (const char* variable : {"MASTER_ADDR", "MASTER_PORT", "RANK", "WORLD_SIZE"})
    any = any || std::getenv(variable) != nullptr;
  if (!any) return std::nullopt;
  constexpr int kMaxProcesses = 4096;
  ProcessPlace place;
  ROOMWISE_TRY(place.count, number_from("WORLD_SIZE", 1, kMaxProcesses));
  ROOMWISE_TRY(place.rank, number_from("RANK", 0, place.count - 1));
  ROOMWISE_TRY(const int port, number_from("MASTER_PORT", 1, 65535));
  place.port = static_cast<std::uint16_t>(port);
  const char* address = std::getenv("MASTER_ADDR");
  if (address == nullptr || *address == '\0')
    return fail("MASTER_ADDR is not set; expected the address of the process of rank 0");
  place.address = address;
  return place;
}

Expected<std::unique_ptr<Processes>> Processes::join(const ProcessPlace& place, bool on_gpu) {
  try {
    c10d::TCPStoreOptions options;
    options.port = place.port;
    options.isServer = place.rank == 0;
    options.timeout = std::chrono::minutes(30);  // as Gloo's own
    options.numWorkers = static_cast<std::size_t>(place.count);
    const auto store = c10::make_intrusive<c10d::TCPStore>(place.address, options);
    return std::make_unique<Group>(place, make_group(store, place, on_gpu), on_gpu);
  } catch (const std::exception& error) {  // c10d's
    return fail("process {} of {} did not meet the others at {}:{}: {}", place.rank, place.count,
                place.address, place.port, first_line(error));
  }
}

std::unique_ptr<Processes> alone() {
  return std::make_unique<Alone>();
}

}  // namespace roomwise::training
