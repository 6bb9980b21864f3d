// What happens to a colour image between two visits: blur, another exposure, noise.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "shared/core/image.h"

namespace kt {

enum class Disturbance {
  kBlur,    ///< Gaussian; level: its standard deviation (px)
  kMotion,  ///< the camera turns while the shutter is open; level: length of the horizontal streak (px)
  kGain,    ///< level: factor of the stored values, which are clipped at 255
  kNoise,   ///< level: standard deviation of each channel (grey values)
};

/// From "blur", "motion", "gain" or "noise".
Disturbance disturbance_of(const std::string& name);

/// `image` disturbed; `seed` chooses the noise. Beyond its border the image goes on with the border's values.
Image<Rgb8> disturbed(const Image<Rgb8>& image, Disturbance kind, double level, uint64_t seed);

}  // namespace kt
