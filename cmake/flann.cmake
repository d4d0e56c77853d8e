# FLANN's C++ interface consists of headers only: libflann_cpp.so exports nothing that we call. Its
# CMake target would link the whole static archive all the same, and its pkg-config file the MPI
# flavour of HDF5, so we take the include directories from the target and leave the rest. The
# headers instantiate the code that saves an index, which calls LZ4.

find_package(flann 1.9 REQUIRED CONFIG)
get_target_property(CCVT_FLANN_INCLUDE_DIRS flann::flann_cpp INTERFACE_INCLUDE_DIRECTORIES)
find_library(CCVT_LZ4_LIBRARY lz4 REQUIRED)
mark_as_advanced(CCVT_LZ4_LIBRARY)
