#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "roomwise/features/surf.h"
#include "roomwise/features/testing/test_pictures.h"

// Counts what this program takes from the heap.
namespace {
std::atomic<int> allocations{0};

void* take(std::size_t bytes) {
  ++allocations;
  if (void* memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
  throw std::bad_alloc();
}
}  // namespace

void* operator new(std::size_t bytes) {
  return take(bytes);
}
void* operator new[](std::size_t bytes) {
  return take(bytes);
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(bytes > 0 ? bytes : 1);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace roomwise::features {
namespace {

// The returned key-points; Eigen takes the descriptors' memory itself.
TEST(SurfMemory, TakesOnlyWhatItReturnsOnceWarm) {
  const SurfExtractor surf({.spread_cells = 4});
  const auto picture = testing::textured_picture(320, 240, 3);
  const int before = allocations;
  const Features first = surf.extract(picture);
  const int between = allocations;
  const Features second = surf.extract(picture);
  EXPECT_GT(between - before, 10);
  EXPECT_EQ(allocations - between, 1);
  EXPECT_EQ(first.size(), second.size());
}

}  // namespace
}  // namespace roomwise::features
