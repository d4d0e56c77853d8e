# GLOBAL: as a sub-project, the targets that ccvt links must exist where ccvt is linked.
find_package(Eigen3 3.4 REQUIRED GLOBAL)
find_package(hwy 1.0 REQUIRED CONFIG GLOBAL)
if(CCVT_PARALLEL STREQUAL "tbb")
  find_package(TBB 2021 REQUIRED CONFIG GLOBAL)
elseif(CCVT_PARALLEL STREQUAL "threads")
  set(THREADS_PREFER_PTHREAD_FLAG ON)
  find_package(Threads REQUIRED GLOBAL)
else()
  message(FATAL_ERROR "CCVT_PARALLEL is \"${CCVT_PARALLEL}\", but must be tbb or threads")
endif()
find_package(ZLIB 1.2 REQUIRED GLOBAL)
include(cmake/flann.cmake)

# stb: single-header image codecs. Debian ships no CMake package for them.
find_path(CCVT_STB_INCLUDE_DIR stb_image.h PATH_SUFFIXES stb REQUIRED)
mark_as_advanced(CCVT_STB_INCLUDE_DIR)

if(CCVT_BUILD_CLI)
  find_package(CLI11 2 REQUIRED CONFIG)
  find_package(nlohmann_json 3 REQUIRED CONFIG)
endif()
