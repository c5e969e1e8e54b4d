#include "roomwise/network/formats/torch_checkpoint_reader.h"

#include <zip.h>

#include <algorithm>
#include <array>

#include "roomwise/network/formats/number_formats.h"
#include "roomwise/network/formats/pickle.h"

namespace roomwise::network {
namespace {

using Kind = PickleValue::Kind;
using Span = std::span<const std::uint8_t>;

constexpr std::string_view kRebuildTensor = "torch._utils._rebuild_tensor_v2";
// What C++ (torch::pickle_save) writes around a dictionary: the dictionary and its type's name.
constexpr std::string_view kRestoreType = "torch.jit._pickle.restore_type_tag";
constexpr std::string_view kRebuildParameter = "torch._utils._rebuild_parameter";

// A zip archive in memory.
class Archive {
 public:
  static Expected<Archive> open(Span bytes) {
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
    zip_t* archive = source == nullptr ? nullptr : zip_open_from_source(source, ZIP_RDONLY, &error);
    if (archive == nullptr) {
      if (source != nullptr) zip_source_free(source);
      const std::string why = zip_error_strerror(&error);
      zip_error_fini(&error);
      return fail("is a PyTorch checkpoint that was cut off or damaged ({})", why);
    }
    return Archive(archive, bytes.size());
  }

  // The folder that holds data.pkl, with its slash.
  Expected<std::string> folder() const {
    constexpr std::string_view kPickle = "/data.pkl";
    std::string folder;
    for (zip_int64_t i = 0; i < zip_get_num_entries(archive_.get(), 0); ++i) {
      const char* name = zip_get_name(archive_.get(), static_cast<zip_uint64_t>(i), 0);
      if (name == nullptr || !std::string_view(name).ends_with(kPickle)) continue;
      if (!folder.empty()) return fail("is a zip archive with more than one data.pkl");
      folder.assign(name, std::string_view(name).size() - kPickle.size() + 1);
    }
    if (folder.empty())
      return fail("is a zip archive without data.pkl, so no checkpoint of PyTorch");
    return folder;
  }

  bool contains(const std::string& name) const {
    return zip_name_locate(archive_.get(), name.c_str(), 0) >= 0;
  }

  // What is read counts: entries that lie over each other must not grow beyond the file.
  Expected<Bytes> read(const std::string& name) {
    zip_stat_t about;
    if (zip_stat(archive_.get(), name.c_str(), 0, &about) != 0 ||
        (about.valid & (ZIP_STAT_SIZE | ZIP_STAT_COMP_METHOD)) !=
            (ZIP_STAT_SIZE | ZIP_STAT_COMP_METHOD)) {
      return fail("lacks \"{}\": the checkpoint is damaged", name);
    }
    if (about.comp_method != ZIP_CM_STORE)
      return fail("has \"{}\" packed; PyTorch writes checkpoints without packing", name);
    if (about.size > unread_bytes_)
      return fail("\"{}\" claims {} bytes, more than the file has", name, about.size);
    unread_bytes_ -= about.size;
    Bytes bytes(about.size);
    const std::unique_ptr<zip_file_t, CloseFile> file(zip_fopen(archive_.get(), name.c_str(), 0));
    if (file == nullptr ||
        zip_fread(file.get(), bytes.data(), bytes.size()) != static_cast<zip_int64_t>(about.size)) {
      return fail("\"{}\" cannot be read: the checkpoint is damaged", name);
    }
    // The sum of the bytes is checked at their end.
    std::uint8_t beyond = 0;
    if (zip_fread(file.get(), &beyond, 1) != 0)
      return fail("\"{}\" is not what its check sum says: the checkpoint is damaged", name);
    return bytes;
  }

 private:
  struct Close {
    void operator()(zip_t* archive) const { zip_discard(archive); }
  };
  struct CloseFile {
    void operator()(zip_file_t* file) const { zip_fclose(file); }
  };
  Archive(zip_t* archive, std::size_t size) : archive_(archive), unread_bytes_(size) {}

  std::unique_ptr<zip_t, Close> archive_;
  std::size_t unread_bytes_;
};

struct Storage {
  NumberFormat format = NumberFormat::kFloat;
  Bytes bytes;
};

class CheckpointReader {
 public:
  CheckpointReader(Archive archive, std::string folder, Pickle pickle, std::size_t file_size)
      : archive_(std::move(archive)),
        folder_(std::move(folder)),
        pickle_(std::move(pickle)),
        unused_values_(file_size) {}

  Expected<Weights> read() {
    const PickleValue* dictionary = &value(pickle_.root);
    if (const auto* tagged = arguments_of(*dictionary, kRestoreType, 1))
      dictionary = &value(tagged->front());
    for (const char* key : {"state_dict", "model"}) {
      if (const PickleValue* inner = entry_of(*dictionary, key)) dictionary = inner;
    }
    if (dictionary->kind != Kind::kDictionary)
      return fail("holds no state dict (a dictionary of tensors)");
    Weights weights;
    for (std::size_t i = 0; i + 1 < dictionary->items.size(); i += 2) {
      const PickleValue& key = value(dictionary->items[i]);
      if (key.kind != Kind::kText) return fail("has a key in its state dict that is no text");
      ROOMWISE_TRY(
          Constant tensor, tensor_of(value(dictionary->items[i + 1])).map_error([&](Error error) {
            return std::move(error).with_context(fmt::format("its tensor \"{}\"", key.text));
          }));
      weights[key.text] = std::make_shared<const Constant>(std::move(tensor));
    }
    return weights;
  }

 private:
  [[nodiscard]] const PickleValue& value(std::size_t place) const { return pickle_.values[place]; }

  // The dictionary that a dictionary holds under this key; null if none.
  [[nodiscard]] const PickleValue* entry_of(const PickleValue& dictionary,
                                            std::string_view key) const {
    if (dictionary.kind != Kind::kDictionary) return nullptr;
    for (std::size_t i = 0; i + 1 < dictionary.items.size(); i += 2) {
      const PickleValue &name = value(dictionary.items[i]), &held = value(dictionary.items[i + 1]);
      if (name.kind == Kind::kText && name.text == key && held.kind == Kind::kDictionary)
        return &held;
    }
    return nullptr;
  }

  // The arguments of a call of `function`; null if it is none, or has fewer than `least`.
  [[nodiscard]] const std::vector<std::size_t>* arguments_of(const PickleValue& call,
                                                             std::string_view function,
                                                             std::size_t least) const {
    if (call.kind != Kind::kCall || value(call.items[0]).text != function) return nullptr;
    const auto& arguments = value(call.items[1]).items;
    return arguments.size() >= least ? &arguments : nullptr;
  }

  [[nodiscard]] Expected<Shape> shape_of(const PickleValue& tuple) const {
    if (tuple.kind != Kind::kTuple) return fail("its shape is no tuple");
    Shape shape;
    for (const std::size_t item : tuple.items) {
      if (value(item).kind != Kind::kInteger || value(item).integer < 0)
        return fail("its shape has a size that is none");
      shape.push_back(value(item).integer);
    }
    return shape;
  }

  Expected<Constant> tensor_of(const PickleValue& given) {
    const PickleValue* call = &given;
    if (const auto* parameter = arguments_of(*call, kRebuildParameter, 1))
      call = &value(parameter->front());
    const auto* arguments = arguments_of(*call, kRebuildTensor, 4);
    if (arguments == nullptr) return fail("it is no tensor");
    const PickleValue& offset = value((*arguments)[1]);
    if (offset.kind != Kind::kInteger || offset.integer < 0) return fail("its offset is none");
    ROOMWISE_TRY(const Storage* storage, storage_of(value((*arguments)[0])));
    ROOMWISE_TRY(const Shape shape, shape_of(value((*arguments)[2])));
    ROOMWISE_TRY(const Shape strides, shape_of(value((*arguments)[3])));
    return strided(*storage, static_cast<std::size_t>(offset.integer), shape, strides);
  }

  // The identity of a storage is ("storage", its type, its key, a device, how many numbers).
  Expected<const Storage*> storage_of(const PickleValue& persistent) {
    if (persistent.kind != Kind::kPersistent) return fail("it has no storage");
    const PickleValue& identity = value(persistent.items.front());
    if (identity.kind != Kind::kTuple || identity.items.size() < 5 ||
        value(identity.items[0]).text != "storage" ||
        value(identity.items[2]).kind != Kind::kText ||
        value(identity.items[4]).kind != Kind::kInteger) {
      return fail("its storage is not named as PyTorch does");
    }
    const auto type = std::ranges::find(number_formats(), value(identity.items[1]).text,
                                        &NumberFormatNames::torch_storage);
    if (type == number_formats().end())
      return fail("its storage is a \"{}\"", value(identity.items[1]).text);
    const std::string& key = value(identity.items[2]).text;
    auto found = storages_.find(key);
    if (found == storages_.end()) {
      ROOMWISE_TRY(Bytes bytes, archive_.read(folder_ + "data/" + key));
      found = storages_.insert({key, {type->format, std::move(bytes)}}).first;
    }
    const std::size_t numbers = found->second.bytes.size() / bytes_of(found->second.format);
    if (found->second.format != type->format ||
        value(identity.items[4]).integer != static_cast<std::int64_t>(numbers)) {
      return fail("its storage \"{}\" has {} numbers, not the {} that it claims", key, numbers,
                  value(identity.items[4]).integer);
    }
    return &found->second;
  }

  Expected<Constant> strided(const Storage& storage, std::size_t offset, const Shape& shape,
                             const Shape& strides) {
    const auto count = values_of(shape);
    if (!count || shape.size() != strides.size())
      return fail("its shape {} is impossible", shape_text(shape));
    // Several tensors may share a storage, or one repeat a number: not without end.
    if (*count > unused_values_) return fail("it is larger than the file can hold");
    unused_values_ -= *count;
    const std::size_t each = bytes_of(storage.format);
    const std::size_t numbers = storage.bytes.size() / each;
    std::size_t last = offset;
    for (std::size_t i = 0; i < shape.size() && *count > 0; ++i) {
      const auto stride = static_cast<std::size_t>(strides[i]);
      const auto steps = static_cast<std::size_t>(shape[i] - 1);
      if (stride > numbers) return fail("its strides lead out of its storage");
      last += steps * stride;
    }
    if (*count > 0 && last >= numbers)
      return fail("it ends at the number {} of a storage of {}", last, numbers);
    if (*count == 0 || is_row_by_row(shape, strides)) {
      const Span all =
          *count > 0 ? Span(storage.bytes).subspan(offset * each, *count * each) : Span();
      return with_shape(numbers_from(storage.format, all), shape);
    }
    Bytes picked;
    picked.reserve(*count * each);
    std::vector<std::int64_t> index(shape.size(), 0);
    for (std::size_t done = 0; done < *count; ++done) {
      std::size_t place = offset;
      for (std::size_t i = 0; i < index.size(); ++i)
        place += static_cast<std::size_t>(index[i] * strides[i]);
      const auto begin = storage.bytes.begin() + static_cast<std::ptrdiff_t>(place * each);
      picked.insert(picked.end(), begin, begin + static_cast<std::ptrdiff_t>(each));
      for (std::size_t i = index.size(); i-- > 0 && ++index[i] == shape[i];) index[i] = 0;
    }
    return with_shape(numbers_from(storage.format, picked), shape);
  }

  static Constant with_shape(Constant constant, const Shape& shape) {
    constant.shape = shape;
    return constant;
  }

  static bool is_row_by_row(const Shape& shape, const Shape& strides) {
    std::int64_t stride = 1;
    for (std::size_t i = shape.size(); i-- > 0; stride *= shape[i]) {
      if (shape[i] != 1 && strides[i] != stride) return false;
    }
    return true;
  }

  Archive archive_;
  std::string folder_;
  Pickle pickle_;
  std::size_t unused_values_;  // of 4 bytes or 8: together at most some times the file
  std::map<std::string, Storage> storages_;
};

bool is_zip(Span bytes) {
  constexpr std::array<std::uint8_t, 4> kZip{'P', 'K', 3, 4};
  return bytes.size() >= kZip.size() && std::ranges::equal(bytes.first(kZip.size()), kZip);
}

// Before PyTorch 1.6 a checkpoint began with the pickle of a magic number.
bool is_old(Span bytes) {
  constexpr std::array<std::uint8_t, 4> kMagic{0x80, 0x02, 0x8A, 0x0A};
  return bytes.size() >= kMagic.size() && std::ranges::equal(bytes.first(kMagic.size()), kMagic);
}

}  // namespace

bool is_torch_checkpoint(Span bytes) {
  return is_zip(bytes) || is_old(bytes);
}

Expected<Weights> read_torch_checkpoint(Span bytes) {
  if (is_old(bytes)) {
    return fail(
        "is a checkpoint in the form of before PyTorch 1.6, which is not read; load it with "
        "torch.load() and write it anew with torch.save()");
  }
  if (!is_zip(bytes)) return fail("is no checkpoint of PyTorch");
  ROOMWISE_TRY(Archive archive, Archive::open(bytes));
  ROOMWISE_TRY(const std::string folder, archive.folder());
  if (archive.contains(folder + "byteorder")) {
    ROOMWISE_TRY(const Bytes order, archive.read(folder + "byteorder"));
    if (std::string(order.begin(), order.end()) != "little")
      return fail("holds numbers with the big end first, which are not read");
  }
  std::vector<std::string_view> globals{kRebuildTensor, kRebuildParameter, kRestoreType};
  for (const NumberFormatNames& type : number_formats()) globals.push_back(type.torch_storage);
  ROOMWISE_TRY(const Bytes pickled, archive.read(folder + "data.pkl"));
  ROOMWISE_TRY(Pickle pickle, read_pickle(pickled, globals));
  return CheckpointReader(std::move(archive), folder, std::move(pickle), bytes.size()).read();
}

}  // namespace roomwise::network
