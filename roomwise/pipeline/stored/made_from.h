#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "roomwise/base/file.h"
#include "roomwise/home/home.h"

namespace roomwise::pipeline {

// What derived data (home::DerivedData) was made from, to be told from what there is now.
class MadeFrom {
 public:
  void add(std::uint64_t number);
  void add(std::string_view text);  // with its length: no two lists of texts give the same
  // Which key-frames there are, and where they are. Their images and cameras never change.
  void add(std::span<const home::Keyframe> keyframes);

  [[nodiscard]] std::string digest() const { return sha256_hex(bytes_); }

 private:
  Bytes bytes_;
};

}  // namespace roomwise::pipeline
