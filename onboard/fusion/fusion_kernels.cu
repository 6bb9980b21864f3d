// CUDA instantiations of the fusion kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/fusion/brick_distance_kernel.h"
#include "onboard/fusion/integrate_kernel.h"
#include "onboard/fusion/raycast_kernel.h"
#include "onboard/fusion/select_bricks_kernel.h"
#include "onboard/fusion/slice_kernel.h"
#include "onboard/fusion/stored_brick_kernel.h"
#include "shared/exec/cuda_launch.cuh"

KT_INSTANTIATE_FOR_EACH_PIXEL(kt::TileRowDepthRange);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::TileDepthRange);
KT_INSTANTIATE_FOR_EACH_LANE(kt::SelectBricks);
KT_INSTANTIATE_FOR_EACH_LANE(kt::FuseColumns);
KT_INSTANTIATE_FOR_EACH(kt::SummariseBrick);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::FindSurfaceBricks);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::SpreadBricks);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::MeasureBrickDistance);
KT_INSTANTIATE_FOR_EACH_PIXEL(kt::RaycastTile);
KT_INSTANTIATE_FOR_EACH_LANE(kt::RaycastPixel);
KT_INSTANTIATE_FOR_EACH(kt::SelectExportBrick);
KT_INSTANTIATE_FOR_EACH(kt::CountSliceRow);
KT_INSTANTIATE_FOR_EACH(kt::WriteSliceRow);
KT_INSTANTIATE_FOR_EACH(kt::MarkFrozenRow);
KT_INSTANTIATE_FOR_EACH(kt::FreezeRow);
KT_INSTANTIATE_FOR_EACH(kt::ClearBrick);
KT_INSTANTIATE_FOR_EACH(kt::SelectLeavingBrick);
KT_INSTANTIATE_FOR_EACH(kt::StoreBrickRow);
KT_INSTANTIATE_FOR_EACH(kt::RestoreBrickRow);
