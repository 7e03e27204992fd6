# SPDX-FileCopyrightText: The arpent authors
# SPDX-License-Identifier: BSD-3-Clause
#
# Compiler settings, the libraries from Debian, and the four ways in which a room declares what it builds.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3" CACHE STRING "" FORCE)

set(ARPENT_SIMD "avx2" CACHE STRING "Instruction set on x86-64: avx2, native or portable")
set_property(CACHE ARPENT_SIMD PROPERTY STRINGS avx2 native portable)
set(ARPENT_SANITIZE "" CACHE STRING "Sanitizers, e.g. address,undefined or thread")

find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()
find_program(MOLD mold)
if(MOLD)
  add_link_options(-fuse-ld=mold)
endif()

add_library(arpent_settings INTERFACE)
target_include_directories(arpent_settings INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(arpent_settings INTERFACE
  -Wall -Wextra -Wpedantic -Werror -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wimplicit-fallthrough
  -ffp-contract=off -fno-math-errno -fno-trapping-math)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # False alarms of gcc 12 on std::string concatenation , fmt and optional-like types (gcc bugs 105329, 105651, 105562).
  target_compile_options(arpent_settings INTERFACE -Wno-restrict -Wno-stringop-overflow -Wno-maybe-uninitialized)
endif()
# Debian's libraries are built for SSE2: Eigen objects that cross over to them keep 16-byte alignment.
target_compile_definitions(arpent_settings INTERFACE EIGEN_MAX_ALIGN_BYTES=16 EIGEN_DONT_PARALLELIZE)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  if(ARPENT_SIMD STREQUAL "avx2")
    target_compile_options(arpent_settings INTERFACE -mavx2 -mfma -mf16c -mbmi2 -mpopcnt -mlzcnt)
  elseif(ARPENT_SIMD STREQUAL "native")
    target_compile_options(arpent_settings INTERFACE -march=native)
  endif()
endif()
if(ARPENT_SANITIZE)
  target_compile_options(arpent_settings INTERFACE -fsanitize=${ARPENT_SANITIZE} -fno-omit-frame-pointer -g1)
  target_link_options(arpent_settings INTERFACE -fsanitize=${ARPENT_SANITIZE})
  if(ARPENT_SANITIZE MATCHES "undefined" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # gcc's vptr check crashes on LCM's pointers to member functions.
    target_compile_options(arpent_settings INTERFACE -fno-sanitize=vptr)
  endif()
  if(ARPENT_SANITIZE MATCHES "undefined")
    target_compile_options(arpent_settings INTERFACE -fno-sanitize-recover=undefined)
  endif()
endif()

if(ARPENT_FUZZ)
  target_compile_options(arpent_settings INTERFACE -fsanitize=fuzzer-no-link)
  target_link_options(arpent_settings INTERFACE -fsanitize=fuzzer-no-link)
endif()

find_package(Eigen3 REQUIRED NO_MODULE)
find_package(yaml-cpp REQUIRED)
find_package(CLI11 REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(GTest REQUIRED)
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(LCM REQUIRED IMPORTED_TARGET lcm)
find_package(apriltag REQUIRED)
find_package(embree 3 REQUIRED)
find_package(assimp REQUIRED)
find_package(Ceres REQUIRED)

# Debian ships OpenCVConfig.cmake only with the 670 MB libopencv-dev, so its modules are found one by one.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
foreach(module core imgproc imgcodecs calib3d features2d video)
  find_library(OPENCV_${module}_LIBRARY opencv_${module} REQUIRED)
  add_library(OpenCV::${module} UNKNOWN IMPORTED)
  set_target_properties(OpenCV::${module} PROPERTIES
    IMPORTED_LOCATION ${OPENCV_${module}_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OPENCV_INCLUDE_DIR})
endforeach()

# All processes and tools, without tests and benchmarks.
add_custom_target(arpent_programs)

# arpent_library(NAME SOURCES … DEPS …): a room's library. DEPS are public.
function(arpent_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC arpent_settings Eigen3::Eigen ${ARG_DEPS})
endfunction()

# arpent_executable(NAME SOURCES … DEPS …): a process or a tool, in bin/.
function(arpent_executable name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE arpent_settings ${ARG_DEPS})
  add_dependencies(arpent_programs ${name})
endfunction()

# arpent_test(NAME SOURCES … DEPS … [LABELS …] [SERIAL]): a GoogleTest binary; ctest sees each of its tests.
# ARPENT_SOURCE_DIR is the project's root at compile time; ARPENT_BIN_DIR is where the executables are.
function(arpent_test name)
  cmake_parse_arguments(ARG "SERIAL" "TIMEOUT" "SOURCES;DEPS;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE arpent_settings ${ARG_DEPS} GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE
    ARPENT_SOURCE_DIR="${CMAKE_SOURCE_DIR}" ARPENT_BIN_DIR="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  set(properties TIMEOUT ${ARG_TIMEOUT})
  if(ARG_LABELS)
    list(APPEND properties LABELS "${ARG_LABELS}")
  endif()
  if(ARG_SERIAL)
    list(APPEND properties RUN_SERIAL TRUE)
  endif()
  include(GoogleTest)
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
endfunction()

# arpent_bench(NAME SOURCES … DEPS …): `./arpent bench NAME` runs bin/bench_NAME.
function(arpent_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(bench_${name} ${ARG_SOURCES})
  target_link_libraries(bench_${name} PRIVATE arpent_settings arpent_bench_harness ${ARG_DEPS})
  target_compile_definitions(bench_${name} PRIVATE
    ARPENT_SOURCE_DIR="${CMAKE_SOURCE_DIR}" ARPENT_BIN_DIR="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
endfunction()

# arpent_fuzz(NAME SOURCES … DEPS …): a libFuzzer target fuzz_NAME, built only with ARPENT_FUZZ.
function(arpent_fuzz name)
  if(NOT ARPENT_FUZZ)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(fuzz_${name} ${ARG_SOURCES})
  target_link_libraries(fuzz_${name} PRIVATE arpent_settings ${ARG_DEPS})
  target_compile_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
  target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
endfunction()
