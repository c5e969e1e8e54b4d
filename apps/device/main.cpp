// roomwise device, alone: for a small board, which needs nothing else of Roomwise.
#include "device_command.h"
#include "roomwise/recording/tum_recording.h"

namespace roomwise::app {
namespace {

// Those of phones and robots want libraries that are many times as large as all the rest here.
Expected<std::unique_ptr<recording::FrameSource>> open_tum_folder(
    const std::filesystem::path& folder) {
  if (!recording::TumRecording::recognises(folder)) {
    return fail(
        "{}: this program reads recordings of rgb.txt and depth.txt alone; 'roomwise device', "
        "which "
        "is in the package roomwise, reads all kinds",
        folder.string());
  }
  return recording::TumRecording::open(folder);
}

}  // namespace
}  // namespace roomwise::app

int main(int argc, char** argv) {
  using namespace roomwise::app;
  CLI::App app(kDeviceDescription, "roomwise-device");
  app.set_version_flag("--version", ROOMWISE_VERSION);
  Context context;
  make_device_command(app, context, open_tum_folder);
  return run(app, context, argc, argv);
}
