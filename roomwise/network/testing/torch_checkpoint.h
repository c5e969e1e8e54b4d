#pragma once

#include <zip.h>

#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "roomwise/base/file.h"

// Checkpoints as torch.save() writes them, made by hand, for tests and as seeds of fuzzing.
namespace roomwise::network::testing {

// Little end first.
inline std::string little(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text.push_back(static_cast<char>(value >> (8 * i)));
  return text;
}
template <typename Number>
std::string raw(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

// Opcodes of protocol 2.
inline std::string pickled(const std::string& text) {
  return "X" + little(text.size(), 4) + text;
}
inline std::string pickled(std::int64_t value) {
  if (value >= 0 && value < 256) return "K" + little(static_cast<std::uint64_t>(value), 1);
  return "J" + little(static_cast<std::uint64_t>(value), 4);
}
inline std::string pickled(const std::vector<std::int64_t>& values) {
  std::string text = "(";
  for (const std::int64_t value : values) text += pickled(value);
  return text + "t";
}
inline std::string global(const std::string& module, const std::string& name) {
  return "c" + module + "\n" + name + "\n";
}
inline std::string ordered_dictionary() {
  return global("collections", "OrderedDict") + ")R";
}

struct SavedTensor {
  std::vector<std::int64_t> shape;
  std::vector<std::int64_t> strides;
  std::string storage;  // its key
  std::string type = "FloatStorage";
  std::int64_t numbers = 0;  // of the storage
  std::int64_t offset = 0;
};
inline std::string pickled(const SavedTensor& tensor) {
  const std::string identity = "(" + pickled("storage") + global("torch", tensor.type) +
                               pickled(tensor.storage) + pickled("cpu") + pickled(tensor.numbers) +
                               "tQ";
  return global("torch._utils", "_rebuild_tensor_v2") + "(" + identity + pickled(tensor.offset) +
         pickled(tensor.shape) + pickled(tensor.strides) + "\x89" + ordered_dictionary() + "tR";
}

// The pickle of a state dict, with the "_metadata" that PyTorch adds.
inline std::string state_dict(const std::vector<std::pair<std::string, SavedTensor>>& tensors) {
  std::string text = ordered_dictionary() + "q" + little(1, 1) + "(";
  for (const auto& [name, tensor] : tensors) text += pickled(name) + pickled(tensor);
  return text + "u}" + pickled("_metadata") + ordered_dictionary() + "sb";
}
inline std::string whole_pickle(const std::string& object) {
  return "\x80\x02" + object + ".";
}

// A zip archive of these files; not packed, as PyTorch writes it, or packed.
inline Bytes zip_archive(const std::map<std::string, std::string>& files, bool packs = false) {
  zip_source_t* memory = zip_source_buffer_create(nullptr, 0, 0, nullptr);
  zip_source_keep(memory);
  zip_t* archive = zip_open_from_source(memory, ZIP_TRUNCATE, nullptr);
  for (const auto& [name, text] : files) {
    zip_source_t* source = zip_source_buffer(archive, text.data(), text.size(), 0);
    const auto index = zip_file_add(archive, name.c_str(), source, 0);
    zip_set_file_compression(archive, static_cast<zip_uint64_t>(index),
                             packs ? ZIP_CM_DEFLATE : ZIP_CM_STORE, 0);
    // So that the same files give the same bytes.
    zip_file_set_mtime(archive, static_cast<zip_uint64_t>(index), 946'684'800, 0);
  }
  if (zip_close(archive) != 0 || zip_source_open(memory) != 0) std::abort();
  zip_source_seek(memory, 0, SEEK_END);
  Bytes bytes(static_cast<std::size_t>(zip_source_tell(memory)));
  zip_source_seek(memory, 0, SEEK_SET);
  zip_source_read(memory, bytes.data(), bytes.size());
  zip_source_close(memory);
  zip_source_free(memory);
  return bytes;
}

// A checkpoint of this pickle and these storages (by key).
inline Bytes checkpoint(const std::string& pickle,
                        const std::map<std::string, std::string>& storages, bool packs = false) {
  std::map<std::string, std::string> files{{"archive/data.pkl", pickle},
                                           {"archive/version", "3\n"}};
  for (const auto& [key, numbers] : storages) files["archive/data/" + key] = numbers;
  return zip_archive(files, packs);
}

}  // namespace roomwise::network::testing
