#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "laboratory/simulation/render/emitters.h"
#include "laboratory/simulation/render/light_bake.h"
#include "roomwise/base/expected.h"

namespace roomwise::simulation {

// Tells one scene from any other: a digest of its shapes, its mean colours and its light.
[[nodiscard]] std::string scene_digest(const Scene& scene, const Emitters& emitters);
// Tells the baked light of one scene from that of any other.
[[nodiscard]] std::string light_key(const std::string& scene_digest, double effort);

// The light that was stored under this key; nothing where there is no such file or it is damaged or
// holds another key's.
[[nodiscard]] std::optional<BakedLight> read_light(const std::filesystem::path& path,
                                                   const std::string& key, const Scene& scene);
[[nodiscard]] Expected<void> write_light(const std::filesystem::path& path, const std::string& key,
                                         const BakedLight& light);

}  // namespace roomwise::simulation
