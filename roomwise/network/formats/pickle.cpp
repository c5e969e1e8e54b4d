#include "roomwise/network/formats/pickle.h"

#include <algorithm>
#include <unordered_map>

namespace roomwise::network {
namespace {

using Kind = PickleValue::Kind;
constexpr std::string_view kOrderedDictionary = "collections.OrderedDict";

// Python's pickletools says what each does.
enum Opcode : std::uint8_t {
  kMark = '(',
  kStop = '.',
  kNone = 'N',
  kNewTrue = 0x88,
  kNewFalse = 0x89,
  kInteger4 = 'J',
  kInteger1 = 'K',
  kInteger2 = 'M',
  kLong1 = 0x8A,
  kFloat = 'G',
  kText4 = 'X',
  kText1 = 0x8C,
  kString4 = 'T',
  kString1 = 'U',
  kBytes4 = 'B',
  kBytes1 = 'C',
  kEmptyTuple = ')',
  kTuple = 't',
  kTuple1 = 0x85,
  kTuple2 = 0x86,
  kTuple3 = 0x87,
  kEmptyList = ']',
  kAppend = 'a',
  kAppends = 'e',
  kEmptyDictionary = '}',
  kSetItem = 's',
  kSetItems = 'u',
  kPut1 = 'q',
  kPut4 = 'r',
  kMemoize = 0x94,
  kGet1 = 'h',
  kGet4 = 'j',
  kGlobal = 'c',
  kStackGlobal = 0x93,
  kReduce = 'R',
  kBuild = 'b',
  kPersistent = 'Q',
  kProtocol = 0x80,
  kFrame = 0x95,
};

class Machine {
 public:
  Machine(std::span<const std::uint8_t> bytes, std::span<const std::string_view> globals)
      : bytes_(bytes), globals_(globals) {}

  Expected<Pickle> run() {
    for (;;) {
      opcode_at_ = at_;
      ROOMWISE_TRY(const std::uint64_t opcode, take_number(1));
      opcode_ = static_cast<std::uint8_t>(opcode);
      if (opcode_ == kStop) break;
      ROOMWISE_RETURN_IF_ERROR(step());
      if (pickle_.values.size() > kMaxValues) return damaged("there are too many objects");
    }
    if (stack_.size() != 1) return damaged("more or less than one object is left");
    pickle_.root = stack_.back();
    return std::move(pickle_);
  }

 private:
  static constexpr std::size_t kMaxValues = std::size_t{1} << 20;

  [[nodiscard]] Unexpected damaged(std::string_view why) const {
    return fail("its pickle, byte {}, opcode 0x{:02x}: {}", opcode_at_, opcode_, why);
  }

  Expected<std::uint64_t> take_number(std::size_t size) {
    if (size > bytes_.size() - at_) return damaged("the pickle ends too early");
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < size; ++i) number |= std::uint64_t{bytes_[at_ + i]} << (8 * i);
    at_ += size;
    return number;
  }
  // A text whose size stands before it in `size_bytes` bytes.
  Expected<std::string> take_text(std::size_t size_bytes) {
    ROOMWISE_TRY(const std::uint64_t size, take_number(size_bytes));
    if (size > bytes_.size() - at_) return damaged("the pickle ends too early");
    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
    at_ += size;
    return std::string(begin, begin + static_cast<std::ptrdiff_t>(size));
  }
  Expected<std::string> take_line() {
    std::string line;
    for (;;) {
      ROOMWISE_TRY(const std::uint64_t letter, take_number(1));
      if (letter == '\n') return line;
      line.push_back(static_cast<char>(letter));
    }
  }

  void push(PickleValue value) {
    pickle_.values.push_back(std::move(value));
    stack_.push_back(pickle_.values.size() - 1);
  }
  void push_integer(std::int64_t integer) { push({Kind::kInteger, integer, {}, {}}); }
  Expected<void> push_text(std::size_t size_bytes) {
    ROOMWISE_TRY(std::string text, take_text(size_bytes));
    push({Kind::kText, 0, std::move(text), {}});
    return {};
  }
  // The topmost `count` objects above the last mark.
  Expected<std::vector<std::size_t>> pop(std::size_t count) {
    const std::size_t floor = marks_.empty() ? 0 : marks_.back();
    if (count > stack_.size() - floor) return damaged("it takes objects that are not there");
    const auto begin = stack_.end() - static_cast<std::ptrdiff_t>(count);
    std::vector<std::size_t> popped(begin, stack_.end());
    stack_.erase(begin, stack_.end());
    return popped;
  }
  // All above the last mark, which goes too.
  Expected<std::vector<std::size_t>> pop_to_mark() {
    if (marks_.empty()) return damaged("there is no mark");
    ROOMWISE_TRY(auto popped, pop(stack_.size() - marks_.back()));
    marks_.pop_back();
    return popped;
  }

  Expected<void> push_tuple(Expected<std::vector<std::size_t>> items) {
    ROOMWISE_TRY(auto members, std::move(items));
    push({Kind::kTuple, 0, {}, std::move(members)});
    return {};
  }
  // Puts the items into the list or dictionary on top.
  Expected<void> put_items(Expected<std::vector<std::size_t>> items, Kind kind) {
    ROOMWISE_TRY(const auto members, std::move(items));
    const std::size_t floor = marks_.empty() ? 0 : marks_.back();
    if (stack_.size() <= floor || pickle_.values[stack_.back()].kind != kind ||
        (kind == Kind::kDictionary && members.size() % 2 != 0)) {
      return damaged("there is nothing to put items into");
    }
    auto& present = pickle_.values[stack_.back()].items;
    present.insert(present.end(), members.begin(), members.end());
    return {};
  }

  Expected<void> push_global(const std::string& module, const std::string& name) {
    const std::string global = module + "." + name;
    if (global != kOrderedDictionary && std::ranges::find(globals_, global) == globals_.end()) {
      return damaged(fmt::format(
          "it asks for \"{}\", which a dictionary of tensors does not need; nothing was run",
          global));
    }
    push({Kind::kGlobal, 0, global, {}});
    return {};
  }
  Expected<void> push_stack_global() {
    ROOMWISE_TRY(const auto names, pop(2));
    const PickleValue &module = pickle_.values[names[0]], &name = pickle_.values[names[1]];
    if (module.kind != Kind::kText || name.kind != Kind::kText)
      return damaged("the name of a global is no text");
    return push_global(std::string(module.text), std::string(name.text));
  }
  Expected<void> reduce() {
    ROOMWISE_TRY(auto call, pop(2));
    const PickleValue &called = pickle_.values[call[0]], &arguments = pickle_.values[call[1]];
    if (called.kind != Kind::kGlobal || arguments.kind != Kind::kTuple)
      return damaged("it calls what cannot be called");
    if (called.text == kOrderedDictionary) {
      if (!arguments.items.empty()) return damaged("an OrderedDict is made of something");
      push({Kind::kDictionary, 0, {}, {}});
    } else {
      push({Kind::kCall, 0, {}, std::move(call)});
    }
    return {};
  }

  Expected<void> push_long() {
    ROOMWISE_TRY(const std::uint64_t size, take_number(1));
    if (size > 8) return damaged("a whole number has more than 64 bits");
    ROOMWISE_TRY(std::uint64_t number, take_number(size));
    const auto unused = static_cast<int>(64 - 8 * size);
    push_integer(size == 0 ? 0 : static_cast<std::int64_t>(number << unused) >> unused);
    return {};
  }

  Expected<void> memoize(std::uint64_t key) {
    if (stack_.empty()) return damaged("there is nothing to remember");
    memo_[key] = stack_.back();
    return {};
  }
  Expected<void> recall(std::uint64_t key) {
    const auto found = memo_.find(key);
    if (found == memo_.end()) return damaged("it recalls what was not remembered");
    stack_.push_back(found->second);
    return {};
  }

  Expected<void> step() {
    switch (opcode_) {
      case kMark:
        marks_.push_back(stack_.size());
        return {};
      case kNone:
        push({});
        return {};
      case kNewTrue:
      case kNewFalse:
        push_integer(opcode_ == kNewTrue ? 1 : 0);
        return {};
      case kLong1:
        return push_long();
      case kText4:
      case kString4:
      case kBytes4:
        return push_text(4);
      case kText1:
      case kString1:
      case kBytes1:
        return push_text(1);
      case kEmptyTuple:
        return push_tuple(std::vector<std::size_t>{});
      case kTuple:
        return push_tuple(pop_to_mark());
      case kTuple1:
      case kTuple2:
      case kTuple3:
        return push_tuple(pop(opcode_ - std::size_t{kTuple1} + 1));
      case kEmptyList:
        push({Kind::kList, 0, {}, {}});
        return {};
      case kEmptyDictionary:
        push({Kind::kDictionary, 0, {}, {}});
        return {};
      case kAppend:
        return put_items(pop(1), Kind::kList);
      case kAppends:
        return put_items(pop_to_mark(), Kind::kList);
      case kSetItem:
        return put_items(pop(2), Kind::kDictionary);
      case kSetItems:
        return put_items(pop_to_mark(), Kind::kDictionary);
      case kMemoize:
        return memoize(memo_.size());
      case kStackGlobal:
        return push_stack_global();
      case kReduce:
        return reduce();
      default:
        return step_with_operand();
    }
  }

  // The opcodes behind which a number, a name or an object stands.
  Expected<void> step_with_operand() {
    switch (opcode_) {
      case kProtocol: {
        ROOMWISE_TRY(const std::uint64_t protocol, take_number(1));
        if (protocol < 2 || protocol > 5) return damaged("2 to 5 are the protocols understood");
        return {};
      }
      case kFrame:
        return take_number(8).map([](std::uint64_t) {});
      case kInteger1:
      case kInteger2:
      case kInteger4: {
        const std::size_t size = opcode_ == kInteger1 ? 1 : opcode_ == kInteger2 ? 2 : 4;
        ROOMWISE_TRY(const std::uint64_t number, take_number(size));
        push_integer(opcode_ == kInteger4 ? static_cast<std::int32_t>(number)
                                          : static_cast<std::int64_t>(number));
        return {};
      }
      case kFloat: {
        ROOMWISE_RETURN_IF_ERROR(take_number(8));
        push({Kind::kNumber, 0, {}, {}});
        return {};
      }
      case kPut1:
      case kPut4: {
        ROOMWISE_TRY(const std::uint64_t key, take_number(opcode_ == kPut1 ? 1 : 4));
        return memoize(key);
      }
      case kGet1:
      case kGet4: {
        ROOMWISE_TRY(const std::uint64_t key, take_number(opcode_ == kGet1 ? 1 : 4));
        return recall(key);
      }
      case kGlobal: {
        ROOMWISE_TRY(const std::string module, take_line());
        ROOMWISE_TRY(const std::string name, take_line());
        return push_global(module, name);
      }
      case kBuild:
        return pop(1).map([](const auto&) {});
      case kPersistent: {
        ROOMWISE_TRY(auto identity, pop(1));
        push({Kind::kPersistent, 0, {}, std::move(identity)});
        return {};
      }
      default:
        return damaged("a dictionary of tensors does not need it");
    }
  }

  std::span<const std::uint8_t> bytes_;
  std::span<const std::string_view> globals_;
  std::size_t at_ = 0;
  std::size_t opcode_at_ = 0;
  std::uint8_t opcode_ = 0;
  Pickle pickle_;
  std::vector<std::size_t> stack_;
  std::vector<std::size_t> marks_;
  std::unordered_map<std::uint64_t, std::size_t> memo_;
};

}  // namespace

Expected<Pickle> read_pickle(std::span<const std::uint8_t> bytes,
                             std::span<const std::string_view> globals) {
  return Machine(bytes, globals).run();
}

}  // namespace roomwise::network
