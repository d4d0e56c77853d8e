# HDF5's C library, serial, for .hdf5 files of particles; without it they are refused. Not by
# find_package(HDF5), which asks a compiler wrapper and may come back with the MPI flavour, whose
# header needs MPI's. On Debian the flavours lie side by side.

option(CCVT_HDF5 "Files of particles in HDF5, where libhdf5 is found" ON)
set(CCVT_WITH_HDF5 OFF)
if(CCVT_HDF5)
  find_path(CCVT_HDF5_INCLUDE_DIR hdf5.h PATH_SUFFIXES hdf5/serial)
  find_library(CCVT_HDF5_LIBRARY NAMES hdf5_serial hdf5)
  mark_as_advanced(CCVT_HDF5_INCLUDE_DIR CCVT_HDF5_LIBRARY)
  if(CCVT_HDF5_INCLUDE_DIR AND CCVT_HDF5_LIBRARY)
    include(CheckCXXSourceCompiles)
    set(CMAKE_REQUIRED_INCLUDES ${CCVT_HDF5_INCLUDE_DIR})
    set(CMAKE_REQUIRED_LIBRARIES ${CCVT_HDF5_LIBRARY})
    check_cxx_source_compiles("#include <hdf5.h>
#if defined(H5_HAVE_PARALLEL) || !H5_VERSION_GE(1, 10, 0)
#error not this one
#endif
int main() { return H5open() < 0; }" CCVT_HDF5_COMPILES)
    unset(CMAKE_REQUIRED_INCLUDES)
    unset(CMAKE_REQUIRED_LIBRARIES)
  endif()
  if(CCVT_HDF5_COMPILES)
    set(CCVT_WITH_HDF5 ON)
  else()
    message(STATUS
      "Serial HDF5 1.10 or later (libhdf5-dev) not found: .hdf5 files of particles are refused")
  endif()
endif()
