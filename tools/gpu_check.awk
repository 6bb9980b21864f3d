# Counts multiply-adds in PTX files (name.ptx) and in a SASS listing of cuobjdump (name.sass), by kernel, for tools/gpu_check.
# SPDX-License-Identifier: BSD-3-Clause
FNR == 1 { kernel = ""; is_sass = FILENAME ~ /\.sass$/ }
!is_sass && /\.(entry|func) / {
  kernel = $0
  sub(/^.*\.(entry|func) +(\([^)]*\) *)?/, "", kernel)
  sub(/[ (].*$/, "", kernel)
  if ($0 ~ /\.entry /) ++kernels
}
!is_sass && /^[ \t]*(@!?%p[0-9]+ )?fma\.([a-z]+\.)*f(16|32|64)/ { ++fused[kernel]; ++fma }
!is_sass && /^[ \t]*(@!?%p[0-9]+ )?(mul|add|sub|mad)\.(ftz\.|sat\.)*f(16|32|64)/ { ++fused[kernel]; ++unrounded }
!is_sass && /^[ \t]*(@!?%p[0-9]+ )?(mul|add|sub)\.rn\./ { ++rounded }
!is_sass && /^[ \t]*(@!?%p[0-9]+ )?(div|rcp|sqrt)\.rn\./ { ++divisions[kernel]; ++all_divisions }
is_sass && /Function : / { kernel = $NF; ++sass_kernels }
is_sass && / (FFMA|DFMA)[. ]/ && kernel !~ /PairResidualILb1E/ { ++sass[kernel]; ++sass_all }
END {
  printf "counts \"kernels\": %d, \"fma\": %d, \"unrounded\": %d, \"rounded\": %d, \"divisions_and_roots\": %d\n", kernels, fma,
      unrounded, rounded, all_divisions
  for (kernel in fused) printf "fused %d products or sums may be fused in %s\n", fused[kernel], kernel
  printf "sass \"kernels\": %d, \"fma\": %d, \"fma_without_division_or_root\": [", sass_kernels, sass_all
  for (kernel in sass) {
    if (!(kernel in divisions)) printf "%s{\"fma\": %d, \"kernel\": \"%s\"}", (listed++ ? ", " : ""), sass[kernel], kernel
  }
  printf "], \"by_kernel\": ["
  listed = 0
  for (kernel in sass) {
    printf "%s{\"fma\": %d, \"divisions_and_roots\": %d, \"kernel\": \"%s\"}", (listed++ ? ", " : ""), sass[kernel],
        divisions[kernel], kernel
  }
  printf "]\n"
}
