#include "device_command.h"

#include "commands.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::app {

void add_device_command(CLI::App& app, Context& context) {
  make_device_command(
      *app.add_subcommand("device", kDeviceDescription), context,
      [](const std::filesystem::path& path) -> Expected<std::unique_ptr<recording::FrameSource>> {
        return recording::open_recording(path);
      });
}

}  // namespace roomwise::app
