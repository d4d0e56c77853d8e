# Debian packages, made by `cpack --preset package`: the shared library, what is needed to build with
# it, and the program.

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ccvt)
set(CPACK_PACKAGE_VENDOR "ccvt")
set(CPACK_PACKAGE_CONTACT "The ccvt maintainers <maintainers@ccvt.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL library development program)
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
 Sites that own equally many points each, as blue noise: for sampling, stippling,
 and codebooks with equally full cells. This is what programs need to run that
 are linked with the library.")
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

# What Debian's policy wants in each package.
set(copyright ${PROJECT_BINARY_DIR}/package/copyright)
file(READ ${PROJECT_SOURCE_DIR}/LICENSE licence)
file(WRITE ${copyright} "Upstream-Name: ccvt\n\n${licence}")
file(WRITE ${PROJECT_BINARY_DIR}/package/changelog
  "ccvt (${PROJECT_VERSION}) unstable; urgency=medium\n\n  * See CHANGELOG.md in libccvt-dev.\n\n"
  " -- ${CPACK_PACKAGE_CONTACT}  Tue, 24 Nov 2026 00:00:00 +0000\n")
find_program(CCVT_GZIP gzip REQUIRED)
mark_as_advanced(CCVT_GZIP)
execute_process(COMMAND ${CCVT_GZIP} -9nf ${PROJECT_BINARY_DIR}/package/changelog
  COMMAND_ERROR_IS_FATAL ANY)
set(packages lib${soname} libccvt-dev ccvt)
foreach(component package IN ZIP_LISTS CPACK_COMPONENTS_ALL packages)
  install(FILES ${copyright} ${PROJECT_BINARY_DIR}/package/changelog.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package}
    COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()
include(CPack)
