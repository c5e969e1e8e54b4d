#pragma once

#include <filesystem>

#include "roomwise/pipeline/exports/picture_dataset.h"

namespace roomwise::pipeline {

// Where the files of a dataset's views go.
struct DatasetFolders {
  std::filesystem::path pictures;
  std::filesystem::path depths;  // empty: depth is not written
};

// The views, without points and names of pictures. Fails where there are none.
[[nodiscard]] Expected<PictureDataset> dataset_views(const home::Home& home,
                                                     const DatasetOptions& options);

// Makes the folders, writes the pictures of the views and gives them their names, and finds the
// points.
[[nodiscard]] Expected<void> write_dataset_pictures(const home::Home& home,
                                                    const DatasetFolders& folders,
                                                    const DatasetOptions& options,
                                                    PictureDataset& dataset, RunContext& run);

}  // namespace roomwise::pipeline
