#pragma once

#include <string>

#include "command.h"

namespace roomwise::app {

// The programs of the laboratory, which stand beside this one where they are installed.
inline constexpr const char* kLaboratory = "roomwise-lab";
inline constexpr const char* kTraining = "roomwise-train";

// This process becomes that program, with the same arguments. Returns only where that fails, saying
// what to install.
[[nodiscard]] Expected<Answer> become_program(const std::string& program);

// Declares the command NAME under `parent`, which is one of another program: whatever follows it is
// left to that program, --help too.
void add_command_elsewhere(CLI::App& parent, Context& context, const std::string& name,
                           const std::string& description, const std::string& program);

}  // namespace roomwise::app
