# Debian packages, made by `cpack --preset package`: the shared library, what is needed to build
# with it, the program, and the Python module where it is built.

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ccvt)
set(CPACK_PACKAGE_VENDOR "ccvt")
set(CPACK_PACKAGE_CONTACT "The ccvt maintainers <maintainers@ccvt.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL library development program)
if(TARGET ccvt_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/src)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

set(soname ccvt${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME lib${soname})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "${PROJECT_DESCRIPTION} (shared library)
 Sites that own equally many points each, as blue noise: for sampling,
 stippling, and codebooks with equally full cells. This is what programs need
 to run that are linked with the library.")
set(triggers ${PROJECT_BINARY_DIR}/package/triggers)
file(WRITE ${triggers} "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${triggers})
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)

set(this_library "lib${soname} (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libccvt-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${this_library}, libeigen3-dev (>= 3.4)")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "${PROJECT_DESCRIPTION} (development files)
 Headers, the CMake package and the pkg-config file, and documents.")

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME ccvt)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "${this_library}")
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "${PROJECT_DESCRIPTION} (program)
 Samples boxes, volumes and surfaces, thins point clouds, stipples pictures,
 trains codebooks with equally full cells, and analyses point sets. With manual
 pages, and completions for bash, zsh and fish.")

# The module is for the one version of Python that it was compiled with. When the package comes, its
# files are compiled; what that made goes with the package.
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-ccvt)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
if(TARGET ccvt_python)
  find_package(Python REQUIRED COMPONENTS Interpreter)  # as src/python has found it: for the version
  math(EXPR next_python "${Python_VERSION_MINOR} + 1")
  string(JOIN ", " CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${this_library}"
    "python3 (>= 3.${Python_VERSION_MINOR})" "python3 (<< 3.${next_python})" python3-numpy)
  set(scripts ${PROJECT_BINARY_DIR}/package/python)
  file(WRITE ${scripts}/postinst "#!/bin/sh\nset -e\npy3compile -p python3-ccvt\n")
  file(WRITE ${scripts}/prerm "#!/bin/sh\nset -e\npy3clean -p python3-ccvt\n")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${scripts}/postinst ${scripts}/prerm)
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-sklearn, python3-tqdm")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "${PROJECT_DESCRIPTION} (Python module)
 Tessellations of NumPy's arrays, samples of volumes and surfaces, stippling,
 analysis of point sets, and k-means with clusters of equal size, in the manner
 of scikit-learn's estimators.")

# What Debian's policy wants in each package. The changelog's date is that of the sources, so that
# the same sources make the same packages: SOURCE_DATE_EPOCH, or the last commit.
set(copyright ${PROJECT_BINARY_DIR}/package/copyright)
file(READ ${PROJECT_SOURCE_DIR}/LICENSE licence)
file(WRITE ${copyright} "Upstream-Name: ccvt\n\n${licence}")
if(NOT DEFINED ENV{SOURCE_DATE_EPOCH})
  execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} log -1 --format=%ct
    OUTPUT_VARIABLE last_commit OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE no_commit)
  if(no_commit)
    message(FATAL_ERROR "Packages need a date, in seconds since 1970, in the environment's "
      "SOURCE_DATE_EPOCH: git knows no last commit of ${PROJECT_SOURCE_DIR}")
  endif()
  set(ENV{SOURCE_DATE_EPOCH} ${last_commit})  # for this run of CMake alone
endif()
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${PROJECT_BINARY_DIR}/package/changelog
  "ccvt (${PROJECT_VERSION}) unstable; urgency=medium\n\n  * See CHANGELOG.md in libccvt-dev.\n\n"
  " -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
execute_process(COMMAND ${CCVT_GZIP} -9nf ${PROJECT_BINARY_DIR}/package/changelog
  COMMAND_ERROR_IS_FATAL ANY)
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  install(FILES ${copyright} ${PROJECT_BINARY_DIR}/package/changelog.gz
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME}
    COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()
include(CPack)
