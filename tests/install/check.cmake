# Installs ccvt and builds and runs the consumer project in every way a user may. Called as
#   cmake -D WAY=installed|configured|sub_project|flags -D SOURCE_DIR= -D BINARY_DIR= -D WORK_DIR= -D GENERATOR=
#         -D COMPILER= -D NM= -D PARALLEL= -P check.cmake
# installed     what BINARY_DIR built, installed to a prefix that is then moved; CMake, pkg-config
# configured    FetchContent, configured only
# sub_project   FetchContent, with a shared library compiled for this very processor, by a project
#               whose flags it does not share; then that library installed, and its symbols (Debug
#               has the -g that tests/abi/check.sh needs)
# flags         the first of them under some sets of flags; flags.sh has more, for both

# Debug, since that compiles fastest.
set(common -G ${GENERATOR} -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_BUILD_TYPE=Debug)
set(consumer ${CMAKE_CURRENT_LIST_DIR})
file(REMOVE_RECURSE ${WORK_DIR})

function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Builds the consumer in WORK_DIR/name with more arguments for CMake, and runs it.
function(consume name)
  run(${CMAKE_COMMAND} -S ${consumer} -B ${WORK_DIR}/${name} ${common} ${ARGN})
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/${name})
  run(${WORK_DIR}/${name}/consumer)
endfunction()

# Documents are there, and every link in them leads to one or to the network.
function(check_documents directory)
  file(GLOB guides RELATIVE ${directory} ${directory}/guides/*.md)
  foreach(name LICENSE README.md CHANGELOG.md architecture.md guides/index.md ${guides})
    if(NOT EXISTS ${directory}/${name})
      message(FATAL_ERROR "${directory}/${name} is not installed")
    endif()
    file(READ ${directory}/${name} text)
    string(REPLACE "](" "link<" text "${text}")  # brackets would not do in a list
    string(REGEX MATCHALL "link<[^) ]*\\)" links "${text}")
    foreach(link IN LISTS links)
      string(REGEX REPLACE "^link<(.*).$" "\\1" target "${link}")
      string(REGEX REPLACE "#.*" "" file "${target}")
      get_filename_component(folder ${directory}/${name} DIRECTORY)
      if(NOT target MATCHES "^https?://" AND NOT EXISTS ${folder}/${file})
        message(FATAL_ERROR "${name}: its link to ${target} leads nowhere")
      endif()
    endforeach()
  endforeach()
endfunction()

# Without LZ4, the package of a static library says that this is what is missing.
function(check_without_lz4 name)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S ${consumer} -B ${WORK_DIR}/${name}_without_lz4 ${common}
      -D CMAKE_PREFIX_PATH=${WORK_DIR}/${name} -D CMAKE_FIND_ROOT_PATH=${WORK_DIR}/nowhere
      -D CMAKE_FIND_ROOT_PATH_MODE_LIBRARY=ONLY
    OUTPUT_QUIET ERROR_VARIABLE errors RESULT_VARIABLE result)
  if(result EQUAL 0 OR NOT errors MATCHES "liblz4-dev")
    message(FATAL_ERROR "Without LZ4, find_package() says: ${errors}")
  endif()
endfunction()

# Installs what was built in `binary_dir` to WORK_DIR/name, and consumes it from there.
function(install_and_consume binary_dir name)
  run(${CMAKE_COMMAND} --install ${binary_dir} --prefix ${WORK_DIR}/not_yet_moved)
  file(RENAME ${WORK_DIR}/not_yet_moved ${WORK_DIR}/${name})
  check_documents(${WORK_DIR}/${name}/share/doc/ccvt)
  consume(${name}_consumer -D CMAKE_PREFIX_PATH=${WORK_DIR}/${name}
    -D CMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)

  # Where the library was built with MPI, its component is there, and the rest without MPI, too.
  file(GLOB_RECURSE mpi ${WORK_DIR}/${name}/*/ccvtMpiTargets.cmake)
  if(mpi)
    set(of_prefix ${common} -D CMAKE_PREFIX_PATH=${WORK_DIR}/${name}
      -D CMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
    run(${CMAKE_COMMAND} -S ${consumer} -B ${WORK_DIR}/${name}_mpi ${of_prefix} -D MPI=ON)
    run(${CMAKE_COMMAND} --build ${WORK_DIR}/${name}_mpi --target consumer_mpi)
    run(${CMAKE_COMMAND} -S ${consumer} -B ${WORK_DIR}/${name}_without_mpi ${of_prefix}
      -D CMAKE_DISABLE_FIND_PACKAGE_MPI=ON)
    execute_process(COMMAND ${CMAKE_COMMAND} -S ${consumer} -B ${WORK_DIR}/${name}_without_mpi -D MPI=ON
      OUTPUT_QUIET ERROR_VARIABLE errors RESULT_VARIABLE result)
    if(result EQUAL 0 OR NOT errors MATCHES "libopenmpi-dev")
      message(FATAL_ERROR "Without MPI, find_package(ccvt COMPONENTS mpi) says: ${errors}")
    endif()
  else()
    execute_process(COMMAND ${CMAKE_COMMAND} -S ${consumer} -B ${WORK_DIR}/${name}_mpi ${common}
      -D CMAKE_PREFIX_PATH=${WORK_DIR}/${name} -D CMAKE_FIND_USE_PACKAGE_REGISTRY=OFF -D MPI=ON
      OUTPUT_QUIET ERROR_VARIABLE errors RESULT_VARIABLE result)
    if(result EQUAL 0 OR NOT errors MATCHES "without -DCCVT_BUILD_MPI=ON")
      message(FATAL_ERROR "Built without MPI, find_package(ccvt COMPONENTS mpi) says: ${errors}")
    endif()
  endif()

  find_program(PKG_CONFIG NAMES pkgconf pkg-config REQUIRED)
  file(GLOB_RECURSE pc ${WORK_DIR}/${name}/*/ccvt.pc)
  cmake_path(GET pc PARENT_PATH pc_dir)
  set(ENV{PKG_CONFIG_PATH} ${pc_dir})
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs ccvt
    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  set(program ${WORK_DIR}/${name}_pkg_config)
  cmake_path(GET pc_dir PARENT_PATH libdir)
  run(${COMPILER} -std=c++20 ${consumer}/main.cpp -o ${program} ${flags} -Wl,-rpath,${libdir})
  run(${program})

  # The examples as a project by itself; of one, all must be found that the others need.
  run(${CMAKE_COMMAND} -S ${consumer}/../examples -B ${WORK_DIR}/${name}_examples ${common}
    -D CMAKE_PREFIX_PATH=${WORK_DIR}/${name} -D CMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/${name}_examples --target example_start)
  run(${WORK_DIR}/${name}_examples/start)
endfunction()

if(WAY STREQUAL "installed")
  install_and_consume(${BINARY_DIR} installed)
  file(GLOB_RECURSE static_library ${WORK_DIR}/installed/*/libccvt.a)
  if(static_library)
    check_without_lz4(installed)
  endif()
elseif(WAY STREQUAL "configured")
  run(${CMAKE_COMMAND} -S ${consumer} -B ${WORK_DIR} ${common} -D CCVT_SOURCE_DIR=${SOURCE_DIR})
elseif(WAY STREQUAL "sub_project")
  # Kernels for one instruction set, as that compiles fastest.
  consume(sub_project -D CCVT_SOURCE_DIR=${SOURCE_DIR} -D BUILD_SHARED_LIBS=ON
    -D CCVT_INSTALL=ON -D CCVT_PARALLEL=${PARALLEL}
    "-DCMAKE_CXX_FLAGS=-DHWY_COMPILE_ONLY_STATIC -march=native -O1 -ffast-math -fno-rtti")
  install_and_consume(${WORK_DIR}/sub_project shared)
  file(GLOB_RECURSE shared_library ${WORK_DIR}/shared/*/libccvt.so)
  run(${CMAKE_COMMAND} -D LIBRARY=${shared_library} -D NM=${NM} -P ${consumer}/symbols.cmake)
elseif(WAY STREQUAL "flags")
  run(${CMAKE_CURRENT_LIST_DIR}/flags.sh --short ${WORK_DIR}
    ${WORK_DIR}/../installed/installed)
endif()
