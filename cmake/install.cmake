# What `cmake --install` puts under the prefix. The prefix may be moved afterwards. Components
# become packages: library, what programs need that are linked with a shared one; development;
# program; python.

include(CMakePackageConfigHelpers)
get_target_property(CCVT_LIBRARY_TYPE ccvt TYPE)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/ccvt)

install(TARGETS ccvt EXPORT ccvtTargets
  LIBRARY COMPONENT library NAMELINK_COMPONENT development
  ARCHIVE COMPONENT development
  FILE_SET HEADERS COMPONENT development)
if(TARGET ccvt_cli)
  # The installed program finds a shared library that was installed beside it.
  cmake_path(RELATIVE_PATH CMAKE_INSTALL_FULL_LIBDIR
    BASE_DIRECTORY ${CMAKE_INSTALL_FULL_BINDIR} OUTPUT_VARIABLE libdir_from_bindir)
  set_target_properties(ccvt_cli PROPERTIES INSTALL_RPATH "$ORIGIN/${libdir_from_bindir}")
  install(TARGETS ccvt_cli COMPONENT program)
  set(pages ${PROJECT_BINARY_DIR}/pages)
  set(manual_pages "*.1")
  if(CCVT_PACKAGE)
    set(manual_pages "*.1.gz")
  endif()
  install(DIRECTORY ${pages}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT program
    FILES_MATCHING PATTERN ${manual_pages})
  install(FILES ${pages}/completions/ccvt.bash RENAME ccvt
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
  install(FILES ${pages}/completions/_ccvt
    DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT program)
  install(FILES ${pages}/completions/ccvt.fish
    DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT program)
endif()
if(TARGET ccvt_mpi)
  install(TARGETS ccvt_mpi EXPORT ccvtMpiTargets
    ARCHIVE COMPONENT development
    FILE_SET HEADERS COMPONENT development)
  install(EXPORT ccvtMpiTargets NAMESPACE ccvt:: DESTINATION ${package_dir} COMPONENT development)
endif()
if(TARGET ccvt_mpi_cli)
  set_target_properties(ccvt_mpi_cli PROPERTIES INSTALL_RPATH "$ORIGIN/${libdir_from_bindir}")
  install(TARGETS ccvt_mpi_cli COMPONENT program)
endif()
if(TARGET ccvt_python AND CCVT_PACKAGE)  # else pip installs it
  set(modules lib/python3/dist-packages)
  install(TARGETS ccvt_python LIBRARY DESTINATION ${modules}/ccvt COMPONENT python)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/python/ccvt DESTINATION ${modules} COMPONENT python
    FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN py.typed PATTERN __pycache__ EXCLUDE)
  file(WRITE ${PROJECT_BINARY_DIR}/package/METADATA "Metadata-Version: 2.1\nName: ccvt\n"
    "Version: ${PROJECT_VERSION}\nSummary: ${PROJECT_DESCRIPTION}\nRequires-Dist: numpy\n")
  install(FILES ${PROJECT_BINARY_DIR}/package/METADATA
    DESTINATION ${modules}/ccvt-${PROJECT_VERSION}.dist-info COMPONENT python)
endif()

install(EXPORT ccvtTargets NAMESPACE ccvt:: DESTINATION ${package_dir} COMPONENT development)
configure_package_config_file(cmake/ccvtConfig.cmake.in ${PROJECT_BINARY_DIR}/ccvtConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/ccvtConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/ccvtConfig.cmake ${PROJECT_BINARY_DIR}/ccvtConfigVersion.cmake
  DESTINATION ${package_dir} COMPONENT development)

# Documents. What their links lead to in the repository is not installed but for the documents: of
# other links and of pictures the text stays.
file(REMOVE_RECURSE ${PROJECT_BINARY_DIR}/documents)  # of guides that are gone
set(documents README.md CHANGELOG.md include/ccvt/README.md)
set(installed_documents README.md CHANGELOG.md architecture.md)
file(GLOB guides CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} src/docs/*.md)
foreach(guide IN LISTS guides)
  cmake_path(GET guide FILENAME name)
  list(APPEND documents ${guide})
  list(APPEND installed_documents guides/${name})
endforeach()
foreach(document installed IN ZIP_LISTS documents installed_documents)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${document})
  file(READ ${document} text)
  string(REPLACE "(include/ccvt/README.md" "(architecture.md" text "${text}")
  string(REPLACE "(../../include/ccvt/README.md" "(:architecture.md" text "${text}")
  string(REPLACE "(../../CHANGELOG.md" "(:CHANGELOG.md" text "${text}")
  string(REPLACE "(src/docs/" "(guides/" text "${text}")
  string(REGEX REPLACE "!\\[([^]]*)\\]\\([^)]*\\)" "*\\1*" text "${text}")
  string(REGEX REPLACE "\\[([^]]*)\\]\\((benchmarks|cmake|include|src|tests|site)/[^)]*\\)" "\\1"
    text "${text}")
  string(REGEX REPLACE "\\[([^]]*)\\]\\(\\.\\./[^)]*\\)" "\\1" text "${text}")
  string(REPLACE "](:" "](../" text "${text}")
  file(WRITE ${PROJECT_BINARY_DIR}/documents/${installed} "${text}")
endforeach()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)
install(DIRECTORY ${PROJECT_BINARY_DIR}/documents/ DESTINATION ${CMAKE_INSTALL_DOCDIR}
  COMPONENT development)

# pkg-config. A static library needs the others to be linked. They are not under Requires.private:
# only one kind of library is installed, so `pkg-config --libs ccvt` should do without --static.
cmake_path(RELATIVE_PATH CMAKE_INSTALL_FULL_INCLUDEDIR
  BASE_DIRECTORY ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig OUTPUT_VARIABLE CCVT_PC_INCLUDEDIR)
set(CCVT_PC_REQUIRES "eigen3 >= 3.4")
set(CCVT_PC_LIBS "")
if(CCVT_LIBRARY_TYPE STREQUAL "STATIC_LIBRARY")
  string(APPEND CCVT_PC_REQUIRES ", libhwy >= 1.0, libjpeg, liblz4, libpng >= 1.6, zlib")
  if(CCVT_PARALLEL STREQUAL "tbb")
    string(APPEND CCVT_PC_REQUIRES ", tbb >= 2021")
  else()
    string(APPEND CCVT_PC_LIBS " -pthread")
  endif()
  if(CCVT_WITH_HDF5)  # by its file: its pkg-config file goes by several names
    cmake_path(GET CCVT_HDF5_LIBRARY STEM hdf5)
    string(REGEX REPLACE "^lib" " -l" hdf5 "${hdf5}")
    string(APPEND CCVT_PC_LIBS "${hdf5}")
  endif()
endif()
configure_file(cmake/ccvt.pc.in ${PROJECT_BINARY_DIR}/ccvt.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/ccvt.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
  COMPONENT development)
