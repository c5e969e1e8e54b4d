#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "laboratory/studies/kept_run.h"
#include "laboratory/studies/paper_results.h"

namespace roomwise::studies {

struct PaperStudyOptions {
  std::filesystem::path data;   // folder of recordings (PaperRecording::folder)
  std::filesystem::path work;   // a folder of the study's own; what is done stays there
  std::filesystem::path truth;  // folder of RECORDING.objects.json: what people marked
  std::vector<PaperPart> parts{PaperPart::kMapping, PaperPart::kObjects, PaperPart::kRooms,
                               PaperPart::kTraining};
  std::uint64_t first_seed = 1;
  int seeds = 1;                                 // maps of each recording, method, feature
  std::string version;                           // of the program; what another made is made anew
  std::vector<std::filesystem::path> networks;   // that look at whole pictures; may be none
  std::optional<std::filesystem::path> trained;  // network that the training begins with
  Words more;                                    // of every run: what changes no result

  // Fails where `data` is no folder, or a number makes no sense.
  [[nodiscard]] Expected<void> validate() const;
};

// Makes what the tables need by runs of `program`, each kept in the work folder as long as what it
// was made of is the same. A run that fails
// is told as missing, with its reason, and the rest goes on; it is tried again the next time.
// Fails only where the options are wrong, the work folder cannot be written to, or it is
// interrupted: the same call goes on from there.
[[nodiscard]] Expected<PaperResults> study_paper(const PaperStudyOptions& options,
                                                 const RunProgram& program, Progress& progress);

}  // namespace roomwise::studies
