#include "laboratory/training/batch_loader.h"

#include <numeric>

#include "roomwise/network/vision/picture_input.h"

namespace roomwise::training {
namespace {

// What streams of random numbers are for, so that none is drawn from twice.
enum Purpose : std::uint64_t { kOrder = 1, kAugmentation = 2 };

}  // namespace

SampleOrder::Sample SampleOrder::sample(std::uint64_t n) {
  const std::uint64_t epoch = n / size_;
  if (order_.empty() || epoch != epoch_) {
    epoch_ = epoch;
    order_.resize(size_);
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    RandomStream random(seed_, {kOrder, epoch});
    for (std::size_t i = size_; i > 1; --i) std::swap(order_[i - 1], order_[random.index(i)]);
  }
  return {epoch, order_[n % size_]};
}

BatchLoader::BatchLoader(const TrainingData& data, const network::ModelCard& card,
                         const BatchLoaderOptions& options, std::int64_t first_step)
    : data_(data),
      card_(card),
      options_(options),
      order_(data.size(), options.seed),
      step_(first_step),
      pool_(options.threads) {
  for (std::size_t i = 0; i < options.ahead; ++i) begin_batch();
}

void BatchLoader::begin_batch() {
  Pending pending;
  const std::int64_t all = options_.batch * options_.processes;
  const std::int64_t first = step_ * all + options_.rank * options_.batch;
  for (std::int64_t i = 0; i < options_.batch; ++i) {
    const auto sample = order_.sample(static_cast<std::uint64_t>(first + i));
    pending.labels.push_back(static_cast<std::int64_t>(data_.label(sample.picture)));
    pending.pictures.push_back(pool_.submit([this, sample]() -> Picture {
      ROOMWISE_TRY(image::ColorImage picture, data_.picture(sample.picture));
      if (options_.augmentation != network::kNoAugmentation) {
        RandomStream random(options_.seed, {kAugmentation, sample.epoch, sample.picture});
        picture = network::augment(picture, options_.augmentation, random);
      }
      return network::picture_input(picture, card_).values;
    }));
  }
  pending_.push_back(std::move(pending));
  ++step_;
}

Expected<Batch> BatchLoader::next() {
  begin_batch();
  Pending pending = std::move(pending_.front());
  pending_.pop_front();
  Batch batch;
  batch.labels = std::move(pending.labels);
  for (std::future<Picture>& future : pending.pictures) {
    ROOMWISE_TRY(const std::vector<float> picture, future.get());
    batch.pictures.insert(batch.pictures.end(), picture.begin(), picture.end());
  }
  return batch;
}

}  // namespace roomwise::training
