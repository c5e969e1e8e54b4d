#pragma once

#include <cstddef>
#include <cstdint>

// One try of a fuzz target, as libFuzzer calls it. Whatever the bytes, it must come back: a crash,
// a sanitizer's finding, endless work or memory without bound are what is looked for.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
