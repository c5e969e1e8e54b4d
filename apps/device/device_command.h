#pragma once

#include <filesystem>
#include <memory>

#include "command.h"
#include "roomwise/recording/frame_source.h"

namespace roomwise::app {

// How a program opens a recording that is sent as if it were a camera: which kinds it reads is its
// own affair.
using OpenRecording =
    Expected<std::unique_ptr<recording::FrameSource>> (*)(const std::filesystem::path& path);

inline constexpr const char* kDeviceDescription =
    "Be a home's device: send what a camera sees, ask, speak what comes back.\n"
    "Keys: w where am I, a around me, f NAME Enter find, g NAME Enter be led there, "
    "? QUESTION Enter ask in your own words, n NAME Enter name the room that is recorded, "
    "m NAME Enter mark this place (no name: remember it), k back there or to where you set out, "
    "s which places you marked, "
    "r repeat, q quiet, x exit.";

// Makes the device of `command`, which is "device" of a program, or a program of its own.
void make_device_command(CLI::App& command, Context& context, OpenRecording open_recording);

}  // namespace roomwise::app
