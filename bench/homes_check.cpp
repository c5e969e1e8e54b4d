// Looks for faults in many made-up homes, by day and with things moved, and walks through each:
//   homes_check [HOMES]        default: 200
// Prints each fault and a summary; exit code 1 where there is one.

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <vector>

#include "arguments.h"
#include "laboratory/simulation/home/home_checks.h"
#include "laboratory/simulation/home/home_generator.h"
#include "laboratory/simulation/home/scenario.h"
#include "laboratory/simulation/walk/walk.h"

namespace {

using namespace roomwise;

std::vector<std::string> faults_of(std::uint64_t seed, simulation::Scenario scenario,
                                   const simulation::FurnitureCatalogue& catalogue) {
  const auto by_day = simulation::generate_home({seed, {}}, catalogue);
  if (!by_day) return {by_day.error().message};
  const simulation::HomeModel home =
      simulation::apply_scenario(*by_day, scenario, seed, catalogue.models());
  std::vector<std::string> faults = simulation::find_faults(home);
  simulation::WalkOptions walk;
  walk.seed = seed;
  walk.frames_per_second = 1;
  if (const auto poses = simulation::plan_walk(home, walk); !poses)
    faults.push_back("walk: " + poses.error().message);
  return faults;
}

}  // namespace

int main(int argc, char** argv) {
  const auto homes = bench::only_count(argc, argv, 200, "homes_check [HOMES]");
  if (!homes) {
    fmt::print(stderr, "{}\n", homes.error().message);
    return 2;
  }
  const auto catalogue = simulation::FurnitureCatalogue::open();
  if (!catalogue) {
    fmt::print(stderr, "{}\n", catalogue.error().message);
    return 1;
  }
  std::uint64_t faulty = 0;
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(*homes); ++seed) {
    for (const auto scenario : {simulation::Scenario::kDay, simulation::Scenario::kMoved}) {
      const auto faults = faults_of(seed, scenario, *catalogue);
      const char* name = scenario == simulation::Scenario::kDay ? "day" : "moved";
      for (const std::string& fault : faults) fmt::print("home {} ({}): {}\n", seed, name, fault);
      faulty += faults.empty() ? 0 : 1;
    }
  }
  fmt::print("{} homes by day and moved: {} with faults\n", *homes, faulty);
  return faulty == 0 ? 0 : 1;
}
