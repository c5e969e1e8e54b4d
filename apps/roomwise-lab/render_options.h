#pragma once

#include "command.h"
#include "laboratory/simulation/render/renderer.h"
#include "paths.h"

namespace roomwise::app {

inline void add_furniture_option(CLI::App& command, std::filesystem::path& furniture) {
  add_setting(command, "--furniture", furniture, "Folder of the furniture's .sh3f archives");
}

// Declares how a home is rendered, and where its furniture is read.
inline void add_render_options(CLI::App& command, simulation::RenderOptions& render,
                               std::filesystem::path& furniture) {
  add_setting(command, "--samples", render.samples_per_pixel, "Rays a pixel");
  add_setting(command, "--bake-effort", render.bake_effort,
              "Rays of the light's bake, relative to the usual; fewer are quicker and blotchy",
              positive());
  add_furniture_option(command, furniture);
}

}  // namespace roomwise::app
