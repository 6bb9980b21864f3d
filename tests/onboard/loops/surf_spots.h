// What our SURF finds in an image of the host.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "onboard/loops/surf_extractor.h"
#include "tests/onboard/loops/warped_image.h"

namespace kt::test {

inline Keypoints surf_keypoints(const Image<float>& image, const SurfConfig& config,
                                const exec::Device& device = exec::Device::cpu(1)) {
  exec::Buffer<float> levels(device, image.pixel_count());
  levels.upload(image.pixels());
  return SurfExtractor(device, image.width(), image.height(), config)
      .extract({levels.data(), image.width(), image.height()});
}

inline std::vector<Spot> spots_of(const Keypoints& keypoints) {
  std::vector<Spot> spots;
  for (size_t i = 0; i < keypoints.size(); ++i) {
    Spot spot{keypoints.u_px[i], keypoints.v_px[i], keypoints.scale_px[i], {}};
    for (size_t k = 0; k < QuantiseDescriptor::kSize; ++k) {
      const auto value = static_cast<int8_t>(keypoints.descriptors[i * QuantiseDescriptor::kSize + k]);
      spot.descriptor.push_back(static_cast<float>(value) / QuantiseDescriptor::kUnits);
    }
    spots.push_back(std::move(spot));
  }
  return spots;
}

inline std::vector<Spot> surf_spots(const Image<float>& image, const SurfConfig& config) {
  return spots_of(surf_keypoints(image, config));
}

}  // namespace kt::test
