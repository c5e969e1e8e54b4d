#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "roomwise/base/file.h"

namespace roomwise::training {

// One of several processes, on one machine or several, that train together.
struct ProcessPlace {
  std::string address;  // of the process of rank 0
  std::uint16_t port = 0;
  int rank = 0;
  int count = 1;

  // As PyTorch's launchers say it: MASTER_ADDR, MASTER_PORT, RANK, WORLD_SIZE. Nothing where none
  // of them is set. Fails where one is missing or no number that it may be.
  [[nodiscard]] static Expected<std::optional<ProcessPlace>> from_environment();
};

// What processes that train together tell each other. Each must make the same calls in the same
// order. Fails where another one is gone.
class Processes {
 public:
  // Waits until all are there, half an hour at most. By Gloo; by NCCL where the tensors are on a
  // GPU and libtorch has it.
  [[nodiscard]] static Expected<std::unique_ptr<Processes>> join(const ProcessPlace& place,
                                                                 bool on_gpu);
  virtual ~Processes() = default;

  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int count() const = 0;
  // Each tensor (of floats) becomes its mean over all processes.
  [[nodiscard]] virtual Expected<void> average(std::span<const at::Tensor> tensors) = 0;
  // Of rank 0, given to all.
  [[nodiscard]] virtual Expected<Bytes> broadcast(Bytes bytes) = 0;
};

// This process alone.
[[nodiscard]] std::unique_ptr<Processes> alone();

}  // namespace roomwise::training
