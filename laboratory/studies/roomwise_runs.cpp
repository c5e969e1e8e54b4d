#include "laboratory/studies/roomwise_runs.h"

#include <string>

namespace roomwise::studies {

namespace fs = std::filesystem;

Words simulate_words(const Words& home, const SimulatedWalk& walk, const fs::path& output) {
  Words words{"simulate"};
  words.insert(words.end(), home.begin(), home.end());
  const std::string seed = std::to_string(walk.seed);
  words.insert(words.end(),
               {"--scenario", std::string(walk.scenario), "--scenario-seed", seed, "--walk-seed",
                seed, "--samples", "2", "--bake-effort", "0.4", "-o", output.string()});
  // Learned from slowly; looked at now and then.
  const bool is_day = walk.name == kDayWalk.name;
  words.insert(words.end(), {"--fps", is_day ? "3" : "0.7"});
  if (is_day) words.emplace_back("--no-fast-turns");
  return words;
}

Words with_networks(Words words, std::span<const fs::path> networks) {
  for (const fs::path& network : networks) {
    words.insert(words.end(), {"--network", network.string()});
  }
  return words;
}

Words room_trial_words(const fs::path& home, int margin) {
  return {"rooms",       "eval",        "--home", home.string(), "--margin", std::to_string(margin),
          "--baselines", "--max-voted", "0"};
}

}  // namespace roomwise::studies
