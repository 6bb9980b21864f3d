// Stands in for the PCD writer where Kintsugi is built without PCL.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/pcd_writer.h"
#include "shared/core/check.h"

namespace kt {

void check_pcd_support() {
  throw Error(
      "this kintsugi was built without PCL, which writes .pcd: install libpcl-dev and build again, or write "
      ".ply");
}

std::string pcd_head(uint32_t, bool, bool) {
  check_pcd_support();
  return {};
}

}  // namespace kt
