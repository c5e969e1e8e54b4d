#pragma once

#include <nlohmann/json.hpp>

#include "roomwise/live/home/live_home.h"

// The home as docs/protocol.md has it. For source files only.
namespace roomwise::live {

using Json = nlohmann::json;

// GET /api/home. Devices are not told of walks, of what changed and of what is to be erased.
[[nodiscard]] Json home_json(const HomeView& view, service::Role role);
[[nodiscard]] Json keyframes_json(const HomeView& view);  // GET /api/map/keyframes
[[nodiscard]] Json plan_json(const HomeView& view);       // GET /api/map/plan
[[nodiscard]] Json edits_json(const HomeView& view);      // GET /api/edits
// GET /api/map/cloud, and /fine
[[nodiscard]] Bytes cloud_bytes(const geometry::PointCloud& cloud_gravity);
[[nodiscard]] Json decision_json(const rooms::RoomDecision& decision);
[[nodiscard]] Json recognitions_json(const std::vector<Recognition>& recognitions);

}  // namespace roomwise::live
