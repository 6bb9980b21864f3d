# Flags shared by every target, and the functions kt_library, kt_program and kt_test.

# CUDA: on where nvcc is found, unless told otherwise.
if(KT_CUDA STREQUAL "AUTO" OR KT_CUDA)
  include(CheckLanguage)
  if(NOT CMAKE_CUDA_ARCHITECTURES)
    # Jetson Orin (87), desktop RTX 20 to 40 (75, 80: its code runs on 86 and 89), data centre (80, 90); the last also as PTX for
    # later parts. Every further one costs a sixth of nvcc's time.
    set(CMAKE_CUDA_ARCHITECTURES 75-real 80-real 87-real 90)
  endif()
  check_language(CUDA)
  if(CMAKE_CUDA_COMPILER)
    enable_language(CUDA)
    find_package(CUDAToolkit REQUIRED)
    if(NOT CMAKE_CUDA20_STANDARD_COMPILE_OPTION)  # CMake 3.25 does not know that nvcc speaks C++20
      set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION "-std=c++20")
      set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION "-std=c++20")
    endif()
    set(CMAKE_CUDA_STANDARD 20)
    set(KT_HAVE_CUDA ON)
  elseif(NOT KT_CUDA STREQUAL "AUTO")
    message(FATAL_ERROR "KT_CUDA=${KT_CUDA} but no nvcc was found: put it on PATH or set CMAKE_CUDA_COMPILER")
  endif()
endif()
message(STATUS "Kintsugi ${PROJECT_VERSION}: CUDA ${KT_HAVE_CUDA}, -march=${KT_MARCH}, ${CMAKE_BUILD_TYPE}")

find_package(Threads REQUIRED)

# Eigen as a CMake package or as bare headers; sources without a package may lie in .deps.
set(KT_DEPS_DIR ${PROJECT_SOURCE_DIR}/.deps CACHE PATH "Folder with sources of libraries that the system lacks: eigen, googletest")
find_package(Eigen3 3.3 QUIET NO_MODULE)
if(NOT TARGET Eigen3::Eigen)
  find_path(EIGEN3_INCLUDE_DIR Eigen/Core PATHS ${KT_DEPS_DIR}/eigen PATH_SUFFIXES eigen3)
  if(NOT EIGEN3_INCLUDE_DIR)
    message(FATAL_ERROR "Eigen was not found: install libeigen3-dev, set EIGEN3_INCLUDE_DIR, or put its headers into ${KT_DEPS_DIR}/eigen")
  endif()
  add_library(Eigen3::Eigen INTERFACE IMPORTED GLOBAL)
  target_include_directories(Eigen3::Eigen INTERFACE ${EIGEN3_INCLUDE_DIR})
endif()
if(NOT KT_CORE_ONLY)
  find_package(CLI11 REQUIRED)
  find_package(nlohmann_json REQUIRED)
  find_package(yaml-cpp REQUIRED)
  find_package(JPEG REQUIRED)
  find_package(ZLIB REQUIRED)
  if(NOT KT_ONBOARD_ONLY)
    find_package(Ceres 2.1 REQUIRED)
  endif()
endif()

# One place for the flags that keep results equal on every machine (ARCHITECTURE.md, determinism). A bench that measures what they
# cost sets KT_CONTRACTED on the target of its one kernel; nothing else may.
add_library(kt_flags INTERFACE)
target_include_directories(kt_flags INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(kt_flags INTERFACE
  # False alarms of g++ 12: -Wrestrict on "literal" + std::string, and, under sanitizers, uninitialised std::optional values.
  $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-restrict $<$<BOOL:${KT_SANITIZE}>:-Wno-maybe-uninitialized>>
  # Compiled together, what is local to one file shadows what is local to another.
  $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<NOT:$<BOOL:${CMAKE_UNITY_BUILD}>>>:-Wshadow>
  $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wnon-virtual-dtor -ffp-contract=off -fno-math-errno -fno-trapping-math>
  $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<BOOL:${KT_MARCH}>>:-march=${KT_MARCH}>
  $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<BOOL:${KT_WERROR}>>:-Werror>
  $<$<COMPILE_LANGUAGE:CUDA>:-fmad=$<IF:$<BOOL:$<TARGET_PROPERTY:KT_CONTRACTED>>,true,false> --ftz=false --prec-div=true
    --prec-sqrt=true --expt-relaxed-constexpr -Xcompiler=-ffp-contract=off>)
# Eigen with SIMD reorders sums and changes struct layouts with the instruction set: keep it scalar.
target_compile_definitions(kt_flags INTERFACE EIGEN_DONT_VECTORIZE EIGEN_MAX_ALIGN_BYTES=16)
target_link_libraries(kt_flags INTERFACE Threads::Threads)
if(KT_SANITIZE)
  target_compile_options(kt_flags INTERFACE
    $<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${KT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all>)
  target_link_options(kt_flags INTERFACE -fsanitize=${KT_SANITIZE})
endif()
if(KT_HAVE_CUDA)
  target_compile_definitions(kt_flags INTERFACE KT_HAVE_CUDA)
endif()

# kt_cuda_sources(<target> <deps> <.cu> ...): adds them to the target, and to those whose PTX the target kt_ptx writes, for
# tools/gpu_check to read.
function(kt_cuda_sources target deps)
  target_sources(${target} PRIVATE ${ARGN})
  target_link_libraries(${target} PUBLIC CUDA::cudart_static)
  add_library(${target}_ptx OBJECT EXCLUDE_FROM_ALL ${ARGN})
  set_target_properties(${target}_ptx PROPERTIES CUDA_PTX_COMPILATION ON)
  target_link_libraries(${target}_ptx PRIVATE kt_flags ${deps})
  if(NOT TARGET kt_ptx)
    add_custom_target(kt_ptx)
  endif()
  add_dependencies(kt_ptx ${target}_ptx)
endfunction()

# kt_library(<folder> SOURCES ... [CUDA ...] [DEPS ...]): the library kt_<folder>; DEPS are public.
function(kt_library folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;CUDA;DEPS" ${ARGN})
  add_library(kt_${folder} STATIC ${ARG_SOURCES})
  target_link_libraries(kt_${folder} PUBLIC kt_flags ${ARG_DEPS})
  if(KT_HAVE_CUDA AND ARG_CUDA)
    kt_cuda_sources(kt_${folder} "${ARG_DEPS}" ${ARG_CUDA})
  endif()
endfunction()

# kt_program(<name> SOURCES ... [CUDA ...] DEPS ... [NO_INSTALL] [PART <part>]): an executable, installed unless told otherwise; PART
# names the Debian package that it goes to: offboard where nothing is said, else onboard or common.
function(kt_program name)
  cmake_parse_arguments(ARG "NO_INSTALL" "PART" "SOURCES;CUDA;DEPS" ${ARGN})
  if(NOT ARG_PART)
    set(ARG_PART offboard)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE kt_flags ${ARG_DEPS})
  if(KT_HAVE_CUDA AND ARG_CUDA)
    kt_cuda_sources(${name} "${ARG_DEPS}" ${ARG_CUDA})
  endif()
  if(NOT ARG_NO_INSTALL)
    install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${ARG_PART})
  endif()
endfunction()

# kt_test(<name> SOURCES ... DEPS ...): one GoogleTest program, each of its tests known to ctest.
function(kt_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;DEPS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE kt_flags ${ARG_DEPS} GTest::gtest GTest::gmock GTest::gtest_main)
  # What is tested is optimised in its library; the tests themselves compile in two thirds of the time so.
  target_compile_options(${name} PRIVATE $<$<AND:$<CONFIG:Release>,$<COMPILE_LANGUAGE:CXX>>:-O1>)
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT ${ARG_TIMEOUT})
endfunction()
