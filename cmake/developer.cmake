# Options for those who work on ccvt, and the compiler settings of every target of ours. Nothing
# here reaches a target that links ccvt.

option(CCVT_WARNINGS_AS_ERRORS "Treat warnings as errors" OFF)
option(CCVT_CLANG_TIDY "Add the target tidy: clang-tidy on the library and the program" OFF)
option(CCVT_FUZZ "Build the fuzzers of the readers, with clang++ and libFuzzer" OFF)
set(CCVT_SANITIZE "" CACHE STRING "Sanitizers: address;undefined or a part of these, or thread")

if(CCVT_SANITIZE MATCHES "thread" AND NOT CCVT_PARALLEL STREQUAL "threads")
  message(FATAL_ERROR
    "CCVT_SANITIZE=thread needs CCVT_PARALLEL=threads: ThreadSanitizer does not see the "
    "synchronization inside a TBB library that was not built with it, and reports false races")
endif()
if(CCVT_CLANG_TIDY)
  find_program(CCVT_RUN_CLANG_TIDY NAMES run-clang-tidy-14 run-clang-tidy REQUIRED)
  set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
  add_custom_target(tidy
    COMMAND ${CCVT_RUN_CLANG_TIDY} -quiet -p ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR}/src/
    USES_TERMINAL VERBATIM)
endif()

# Applies to a target of ours: C++20, warnings, sanitizers. SLIGHTLY optimised is what has no loops
# that take time, or is compiled to be tested with: in a release it compiles in two thirds of the
# time. LIKE another target, compiled by the same settings, is what shares its precompiled headers;
# ALONE is what has a source or two: precompiling takes longer than those.
function(ccvt_compile_settings target)
  cmake_parse_arguments(PARSE_ARGV 1 settings "SLIGHTLY;ALONE" "LIKE" "")
  if(settings_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "ccvt_compile_settings(${target}): unknown ${settings_UNPARSED_ARGUMENTS}")
  endif()
  if(settings_SLIGHTLY)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
  target_compile_features(${target} PRIVATE cxx_std_20)
  set_target_properties(${target} PROPERTIES
    CXX_EXTENSIONS OFF
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    COMPILE_WARNING_AS_ERROR ${CCVT_WARNINGS_AS_ERRORS})
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # GCC 12 takes "text" + string for overlapping copies: https://gcc.gnu.org/PR105651
    target_compile_options(${target} PRIVATE -Wno-restrict)
    if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
      # It forgets that headers are the system's when they are precompiled, and then finds more.
      target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-stringop-overflow
        -Wno-stringop-overread)
    endif()
  endif()

  # Half of the time that a file takes to compile goes into these. The presets dev and tidy switch
  # them off, so that a missing #include is found.
  if(settings_LIKE)
    target_precompile_headers(${target} REUSE_FROM ${settings_LIKE})
  elseif(NOT settings_ALONE)
    target_precompile_headers(${target} PRIVATE
      <Eigen/Core> <algorithm> <array> <atomic> <chrono> <cmath> <condition_variable> <filesystem>
      <fstream> <functional> <limits> <map> <memory> <mutex> <numeric> <optional> <span> <sstream>
      <stdexcept> <string> <thread> <tuple> <utility> <variant> <vector>)
  endif()

  # A fused multiply-add rounds once where a multiplication and an addition round twice. Compilers
  # contract wherever the instruction set has one, so without this flag the bits of a result would
  # depend on the processor that the code was compiled for, or dispatched to.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  # Flags of a project that this is a part of reach it too. With -ffast-math no NaN is found in what
  # is given, and sums change their order; and types and exceptions are needed at run time.
  target_compile_options(${target} PRIVATE -fno-fast-math -frtti -fexceptions)

  # Kernels take long to compile, once for each instruction set. What had SSSE3 or SSE4 but no AVX2
  # was sold until 2013: one number at a time serves there, of which compilers make SSE2. Sanitized
  # they take a minute each, so two must do. AVX3_DL gains nothing here, and Highway 1.0 does not
  # build where it is the baseline.
  set(unused HWY_SSSE3|HWY_SSE4|HWY_AVX3_DL)
  if(CCVT_SANITIZE)
    string(APPEND unused |HWY_AVX3)
  endif()
  target_compile_definitions(${target} PRIVATE "HWY_DISABLED_TARGETS=(${unused})")

  if(CCVT_SANITIZE)
    # Points have numbers of four bytes, and beyond 2^32 points of five: here beyond 2^12, so that what
    # solvers, ranks and checkpoints do with these is tested wherever their tests run.
    target_compile_definitions(${target} PRIVATE CCVT_TEST_POINT_BITS=12)
    list(JOIN CCVT_SANITIZE "," sanitizers)
    target_compile_options(${target} PRIVATE
      -fsanitize=${sanitizers} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=${sanitizers})
  endif()
endfunction()
