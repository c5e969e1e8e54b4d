// Gives a fuzz target every file of a folder, once.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "fuzz_target.h"
#include "roomwise/base/file.h"

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  std::error_code error;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(argc == 2 ? argv[1] : "", error)) {
    files.push_back(entry.path());
  }
  if (files.empty()) {
    std::fprintf(stderr, "usage: %s FOLDER, which holds at least one file\n", argv[0]);
    return 2;
  }
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    const auto bytes = roomwise::read_file(file);
    if (!bytes) {
      std::fprintf(stderr, "%s\n", bytes.error().message.c_str());
      return 1;
    }
    LLVMFuzzerTestOneInput(bytes->data(), bytes->size());
  }
  std::printf("%zu files\n", files.size());
  return 0;
}
