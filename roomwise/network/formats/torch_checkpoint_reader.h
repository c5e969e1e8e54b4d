#pragma once

#include "roomwise/network/formats/weights_file.h"

namespace roomwise::network {

// Whether it is what torch.save() of Python writes: a zip archive, or (before PyTorch 1.6) pickles.
[[nodiscard]] bool is_torch_checkpoint(std::span<const std::uint8_t> bytes);

// The tensors of a state dict as torch.save() writes it since PyTorch 1.6: a zip archive with the
// pickle "NAME/data.pkl" and the numbers "NAME/data/KEY". Also of a dictionary that holds the state
// dict under "state_dict" or "model". Only data are read (pickle.h); nothing of the file is run.
//
// Floats of 16, 32 and 64 bits, bfloat16, whole numbers of 32 and 64 bits, booleans; in any
// strides. Fails, naming the tensor or the pickle's opcode, on anything else, on damage, on packed
// archives (PyTorch packs none) and where the tensors would take more than four times the file.
[[nodiscard]] Expected<Weights> read_torch_checkpoint(std::span<const std::uint8_t> bytes);

}  // namespace roomwise::network
