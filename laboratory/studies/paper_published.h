#pragma once

#include <span>
#include <string_view>

// Figures that others published, or that others' programs reached on the same files, beside which
// ours stand. None is made up here: docs/experiments/paper-tables.md lists them.
namespace roomwise::studies {

struct Source {
  std::string_view name;
  std::string_view about;  // what the figures are, a sentence
  bool is_published;       // by those who made it; else their program was run on the same files
};
[[nodiscard]] std::span<const Source> published_sources();

struct PublishedTrajectory {
  std::string_view recording;  // title of a PaperRecording
  std::size_t source;          // of published_sources()
  std::string_view frames;     // with a pose; empty: not told
  std::string_view ate_m;
  std::string_view cpu_ms;  // a frame; empty: not told
};
[[nodiscard]] std::span<const PublishedTrajectory> published_trajectories();

struct PublishedRooms {
  std::string_view changed;
  std::string_view way;
  std::size_t source;
  std::string_view precision;
  std::string_view ms;  // a decision
};
[[nodiscard]] std::span<const PublishedRooms> published_rooms();

}  // namespace roomwise::studies
