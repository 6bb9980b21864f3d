// How large a time stamp can be: the one limit for files, messages and sources.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace kt {

/// Stamps lie within +- this (us): the year 5138 in Unix time. Milliseconds that were taken for seconds do
/// not.
inline constexpr int64_t kMaxTimestamp_us = int64_t{100'000'000'000} * 1'000'000;

}  // namespace kt
