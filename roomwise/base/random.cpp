#include "roomwise/base/random.h"

#include <cmath>
#include <numbers>

namespace roomwise {
namespace {

std::uint64_t splitmix64(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::initializer_list<std::uint64_t> key) {
  std::uint64_t mix = seed;
  for (const std::uint64_t part : key) mix = splitmix64(mix) ^ (part + 0x632be59bd9b4e019ULL);
  for (std::uint64_t& word : state_) word = splitmix64(mix);
}

double RandomStream::normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

}  // namespace roomwise
