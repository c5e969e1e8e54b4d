#pragma once

#include <filesystem>
#include <string>

#include "python/bindings/outcome.h"
#include "roomwise/home/home.h"
#include "roomwise/pipeline/objects/keyframe_observer.h"

namespace roomwise::python {

// A home as Python holds it, for reading. Its database is used on Python's thread alone, with the
// GIL held; long work reads the file by a Home of its own (reader()).
struct OpenHome {
  std::filesystem::path path;
  home::OpenOptions options;
  home::Home home;

  // May be called without the GIL.
  [[nodiscard]] Expected<home::Home> reader() const {
    return home::Home::open_read_only(path, options);
  }
};

// None, or the passphrase of a protected home.
[[nodiscard]] home::OpenOptions open_options(const py::object& passphrase);

// What users give as networks: None, the installed ones, or a list of files or names; an empty one
// means none.
struct ChosenNetworks {
  bool are_installed = true;
  std::vector<std::filesystem::path> files;

  [[nodiscard]] static ChosenNetworks of(const py::object& networks);
  // As they look at the home's pictures. May be called without the GIL.
  [[nodiscard]] Expected<pipeline::Networks> load(const home::Home& home, bool also_brought) const;
};

// 0: one thread a processor.
[[nodiscard]] std::size_t thread_count(int threads);

}  // namespace roomwise::python
