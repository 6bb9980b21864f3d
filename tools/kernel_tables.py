# Turns the JSON of kintsugi-core-bench --suite and of tools/gpu_check into sections of tools/benchmark.
# SPDX-License-Identifier: BSD-3-Clause
from benching import table

STAGES = ("frame", "preprocess", "track", "integrate", "raycast")
TRAFFIC = ("integrate", "raycast")
RUN = ("voxels", "mm", "image")

TEXT = """## {heading}
`kintsugi-core-bench --suite` on {device}: closed-form scenes, no noise, each stage waited for. Median milliseconds.

{times}
The same runs against the memory bandwidth: {bandwidth:.1f} GB/s, measured beside them by the triad a = b + s c over three arrays of {array_mib:.0f} MiB.
MB: what the result of one frame proves to have moved, whatever the kernels are. Integrate: each row of 8 voxels (32 bytes) and of
their colours (64 bytes) that changed, read and written, and each fusion pixel, read. Raycast: each row that holds one of the 8 voxels
around a predicted point, each brick's state, and each point and normal. Lists, flags, pyramids and what rays cross on their way are
not counted, so the share is a lower bound of what the memory does and, but for what the caches keep, its inverse is the most that
could be won.

{traffic}
Growth: e of time ~ size^e, from images of 320 x 240 to 1280 x 960 over 512 voxels of 1 cm, and from 128 to 512 voxels per axis over the same
5.12 m; 1 is linear in pixels or in voxels, 0 is none.

{growth}
Mission: {mission_frames} frames of 320 x 240 along a corridor, 256 voxels of 2 cm; {slices} slices leave the volume and keyframes gather. Median
frame of the first tenth {first:.2f} ms, of the last {last:.2f} ms.

Equal bits: {residuals} residuals sum in {fixed:.3f} ms in the fixed order, in {unordered:.3f} ms as a plain float sum in whatever order threads come:
{fixed_to_unordered:.2f} times as long. {contracted}
"""

GPU_TEXT = """## On a GPU
What `tools/gpu_check` last said (`docs/gpu_check.json`): {verdict}. {gpu}, {cpu}, {cores} cores. Of {run} tests of the core {passed} passed and {failed} failed;
{compared} tests compared the GPU with the CPU bit for bit. compute-sanitizer: {sanitizers}. The same suite on that machine's CPU:

{times}"""


def gpu_section(check):
    """The section of a report of tools/gpu_check; a KeyError where it lacks a figure, as one of a check without a GPU does."""
    steps, machine = check["steps"], check["machine"]
    tests, on_gpu, on_cpu = steps["tests"], steps["bench_cuda"]["report"], steps["bench_cpu"]["report"]
    sanitizers = ", ".join(f"{tool} found {steps[tool]['errors']} errors" if "errors" in steps[tool] else f"{tool} was not run"
                           for tool in ("memcheck", "initcheck", "racecheck"))
    text = GPU_TEXT.format(verdict="all is well" if check["ok"] else check["why"], gpu=machine["gpu"], cpu=machine["cpu"],
                           cores=machine["cores"], run=tests["run"], passed=tests["passed"], failed=tests["failed"],
                           compared=tests["compared_with_gpu"], sanitizers=sanitizers, times=times_table(on_cpu))
    return text + "\n" + kernels_section(on_gpu, f"Kernels on that GPU (Kintsugi {on_gpu['program_version']})")


def run_name(run):
    return [f"{run['volume_resolution']}³", f"{1000 * run['voxel_size_m']:.0f}", f"{run['width']} x {run['height']}"]


def times_table(report):
    # A GPU's hundredths of a millisecond count.
    digits = 2 if report["device"] == "cuda" else 1
    return table([*RUN, *STAGES], [run_name(run) + [f"{run['stages'][stage]['p50_ms']:.{digits}f}" for stage in STAGES]
                                   for run in report["runs"]])


def kernels_section(report, heading="Kernels"):
    """The section; a KeyError where the report lacks a figure."""
    traffic = []
    for run in report["runs"]:
        cells = [run["traffic"][stage] for stage in TRAFFIC]
        traffic.append(run_name(run) + [text for cell in cells for text in (f"{cell['bytes'] / 1e6:.1f}", f"{cell['gb_per_s']:.2f}",
                                                                            f"{100 * cell['share_of_bandwidth']:.1f}")])
    growth = [[name] + [f"{report['growth'][key][stage]:.2f}" for stage in STAGES]
              for name, key in (("pixels", "with_pixels"), ("voxels", "with_voxels"))]
    mission, sums = report["mission"], report["reductions"]
    contracted = ("No compiler may make SIMD of a plain sum; the fixed order is made for it. What it costs that multiply and add are not fused "
                  "is measured on a GPU only.")
    if "contracted_ms" in sums:
        contracted = (f"With multiply and add fused the first takes {sums['contracted_ms']:.3f} ms: not fusing them costs a factor of "
                      f"{sums['fixed_to_contracted']:.2f}.")
    device = report["device"] + (f" ({report['threads']} threads)" if report["device"] == "cpu" else "")
    return TEXT.format(
        heading=heading, device=device, times=times_table(report), bandwidth=report["bandwidth"]["gb_per_s"],
        array_mib=report["bandwidth"]["bytes_per_array"] / 2**20,
        traffic=table([*RUN, *(f"{stage} {what}" for stage in TRAFFIC for what in ("MB", "GB/s", "% of bandwidth"))], traffic),
        growth=table(["with", *STAGES], growth), mission_frames=mission["frames"], slices=mission["slices"],
        first=mission["first_tenth_p50_ms"], last=mission["last_tenth_p50_ms"], residuals=sums["residuals"],
        fixed=sums["fixed_order_ms"], unordered=sums["unordered_ms"], fixed_to_unordered=sums["fixed_to_unordered"],
        contracted=contracted)
